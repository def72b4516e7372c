"""Semismooth Newton method for the contact conditions of one pairing of two surfaces."""

from solvers.newton.iteration import SemismoothNewton

__all__ = ["SemismoothNewton"]
