"""Laws of friction, of wear, of layers on and between the surfaces, and of yielding, and the local state they depend
on.
"""
