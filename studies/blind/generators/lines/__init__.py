"""Blind records of line contacts, made by the program's own finite elements."""
