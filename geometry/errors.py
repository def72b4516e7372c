"""The base class of all errors of this program, and the error class of the geometry package."""


class WirewearError(Exception):
    """Base of every error that this program raises. Its message is one sentence: what is wrong, where, what would be
    right.
    """


class GeometryError(WirewearError):
    """The dimensions or mesh sizes that are asked for cannot be meshed."""
