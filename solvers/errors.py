"""The error type of the solvers package."""


class SolverError(Exception):
    """A problem cannot be solved as asked; the message is one sentence for the user."""
