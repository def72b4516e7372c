"""The error type of the solvers package."""

from geometry.errors import WirewearError


class SolverError(WirewearError):
    """A computation cannot be done as asked, or did not converge."""


class PatchLeftError(SolverError):
    """The contact has reached the edge of a body's finely meshed patch."""


class NotConvergedError(SolverError):
    """An increment did not converge, even when cut as short as allowed."""
