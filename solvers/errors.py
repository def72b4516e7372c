"""The error type of the solvers package."""


class SolverError(Exception):
    """A computation cannot be done or did not converge; the message is one sentence for the user."""


class PatchLeftError(SolverError):
    """The contact has left a body's finely meshed patch."""


class NotConvergedError(SolverError):
    """An increment did not converge, however short it was made."""
