"""The root of all errors, and the error type of the geometry package."""


class WirewearError(Exception):
    """Base of every error that this program raises; the message is one sentence: what, where, what would be right."""


class GeometryError(WirewearError):
    """A body cannot be meshed as asked."""
