"""What can go wrong with a blind batch."""

from wirewear.base.errors import WirewearError


class BlindError(WirewearError):
    """A blind batch cannot be made, opened or scored."""
