"""Semismooth Newton method for the contact conditions of two surfaces in one relative position (one pairing)."""

from solvers.newton.iteration import SemismoothNewton

__all__ = ["SemismoothNewton"]
