"""Tiers T0 and T1: records of the program's own finite elements. The only part that knows the simulation."""
