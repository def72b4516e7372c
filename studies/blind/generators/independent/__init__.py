"""Tier T2: a forward model that shares nothing with the finite elements or the diagnosis.

Wires on an elastic foundation, a friction law other than Coulomb's, energy wear by stabilised explicit jumps, a rig and
sensors of its own. It imports no solver, no effect and no diagnosis; a test holds it to that.
"""
