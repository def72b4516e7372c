"""The error type of the solvers package."""

from geometry.errors import WirewearError


class SolverError(WirewearError):
    """A computation cannot be done as asked, or did not converge."""


class PatchLeftError(SolverError):
    """The contact has reached the edge of a body's finely meshed patch."""


class NotConvergedError(SolverError):
    """A solution was not found within the allowed iterations, in an increment even when cut as short as allowed."""
