"""Numbers and lists as they stand in sentences."""

from collections.abc import Sequence

from wirewear.quantity import counted

MOST_LISTED = 8


def plural(count: int, noun: str) -> str:
    """``1 loop``, ``3 loops``."""
    return f"{counted(count)} {noun}{'' if count == 1 else 's'}"


def listed(values: Sequence[int]) -> str:
    """``1, 2, 3 and 12 more``."""
    shown = ", ".join(counted(value) for value in values[:MOST_LISTED])
    more = len(values) - MOST_LISTED
    return f"{shown} and {more} more" if more > 0 else shown
