"""Nominal runs that are kept: found in the cache, or made in a folder of passage and put there."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TypeVar

from wirewear.base.errors import ResultError

Result = TypeVar("Result")

_FOLDER = "wirewear-nominal-"


def kept_or_made(
    name: str, read: Callable[[Path], Result], make: Callable[[Path], tuple[Result, Path]]
) -> tuple[Result, Path | None]:
    """A result by the name of its file in the cache, and that file, None where nothing can be kept.

    read: of that file; one that is damaged is made anew.  make: in a folder, the result and its file there.
    """
    from wirewear.base.cache import allowed_bytes, keep_within, kept_file, mark_used, not_kept, remove_abandoned
    from wirewear.base.writing import temporary_folder, write_bytes

    path = kept_file(name)
    if path is not None and path.exists():
        with suppress(ResultError):
            result = read(path)
            mark_used(path)
            return result, path
    with temporary_folder(_FOLDER) as folder:
        remove_abandoned(folder.parent, f"{_FOLDER}*")
        result, made = make(folder)
        if path is not None:
            try:
                write_bytes(path, made.read_bytes())
                keep_within(path.parent, allowed_bytes(), newest=path)
            except OSError as problem:
                not_kept(path, problem)
    return result, path
