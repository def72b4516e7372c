"""The base class of all errors of this program, and the error class of the geometry package."""


class WirewearError(Exception):
    """Base of every error that this program raises. Its message is a sentence: what is wrong, where, what would do."""


class GeometryError(WirewearError):
    """A body cannot be meshed as asked, or its file cannot be used."""
