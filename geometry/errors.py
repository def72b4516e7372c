"""The error type of the geometry package."""


class GeometryError(Exception):
    """A body cannot be meshed as asked; the message is one sentence for the user."""
