"""Showing how far something is that takes its time, without knowing where it is shown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Protocol, TypeVar

T = TypeVar("T")


class Tracked(Protocol):
    """Passes on what is done one after the other, and may show how far that is."""

    def __call__(self, each: Sequence[T], doing: str, /) -> Iterable[T]:
        """The same, in its order; `doing` says what is done with it."""


def untracked(each: Sequence[T], _doing: str, /) -> Iterable[T]:
    """The same, with nothing shown."""
    return each
