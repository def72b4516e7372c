"""The error type of the solvers package."""

from geometry.errors import WirewearError


class SolverError(WirewearError):
    """A computation cannot be done or did not converge."""


class PatchLeftError(SolverError):
    """The contact has left a body's finely meshed patch."""


class NotConvergedError(SolverError):
    """An increment did not converge, however short it was made."""
