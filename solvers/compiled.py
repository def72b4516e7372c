"""Compilation of the inner loops to machine code."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

from numba import njit

F = TypeVar("F", bound=Callable[..., object])


def compiled(function: F) -> F:
    """The function compiled by numba when it is first called; the code is kept on disk for later processes.

    Kept beside the source, in the user's cache where that cannot be written, or in NUMBA_CACHE_DIR.
    """
    return cast(F, njit(cache=True, error_model="numpy")(function))
