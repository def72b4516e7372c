"""Elasticity, frictional contact with finite sliding, wear and cycle jumps."""

from solvers.errors import SolverError

__all__ = ["SolverError"]
