"""The folder of what is kept to be used again: its owner's alone, and within a size.

What stands in it is used without being computed again, so nobody else may write there. Where no such folder can be had,
nothing is kept, and a warning says so once.
"""

import os
import shutil
import warnings
from contextlib import suppress
from pathlib import Path
from time import time

from solvers.kept_code import chosen_cache, private_folder
from wirewear.base.errors import KeptNothingWarning
from wirewear.base.writing import why_not_written

DEFAULT_GB = 10.0  #: Gigabytes that are kept, unless WIREWEAR_CACHE_GB says otherwise.
_KEPT = ("body-*.npz", "wire-*.npz", "nominal-*.h5")  #: What is kept, by the names of the files.
WARNED: set[str] = set()  #: What was warned of, in this process or in the one that started it.
_ABANDONED_s = 86_400.0  #: Nothing that is kept takes a day to be made: what is unfinished after one belongs to nobody.


def cache_directory() -> Path | None:
    """The folder, made if need be: WIREWEAR_CACHE, else the user's cache folder; None where neither can be used.

    In a folder that others can write to, or that is another's, it is one of the user's own.
    """
    try:
        return private_folder(chosen_cache())
    except (OSError, RuntimeError, ValueError) as problem:
        reason = why_not_written(problem) if isinstance(problem, OSError) else str(problem)
        _warn_once(f"{os.environ.get('WIREWEAR_CACHE') or 'the cache folder'} cannot be used ({reason})")
        return None


def kept_file(name: str) -> Path | None:
    """Where a file of that name is kept; None where nothing is."""
    folder = cache_directory()
    return None if folder is None else folder / name


def allowed_bytes() -> float:
    """The size from WIREWEAR_CACHE_GB, or the default one if that is no number of zero or more."""
    with suppress(ValueError):
        chosen = float(os.environ.get("WIREWEAR_CACHE_GB", DEFAULT_GB))
        if chosen >= 0.0:
            return 1e9 * chosen
    return 1e9 * DEFAULT_GB


def mark_used(path: Path) -> None:
    """Note that a kept file is of use now."""
    with suppress(OSError):
        os.utime(path)


def not_kept(path: Path, problem: OSError) -> None:
    """Warn, once, that a file could not be kept."""
    _warn_once(f"nothing can be written to the cache folder {path.parent} ({why_not_written(problem)})")


def remove_abandoned(directory: Path, pattern: str) -> None:
    """Delete files and folders of that pattern which somebody who was killed has left unfinished."""
    for left in directory.glob(pattern):
        with suppress(OSError):
            if time() - left.stat().st_mtime > _ABANDONED_s:
                if left.is_dir():
                    shutil.rmtree(left)
                else:
                    left.unlink()


def keep_within(directory: Path, allowed: float, newest: Path | None = None) -> None:
    """Delete what is kept until the rest takes at most `allowed` bytes, least recently used first, `newest` never.

    Files that go or cannot be deleted meanwhile are left to whoever holds them.
    """
    kept = []
    for pattern in _KEPT:
        remove_abandoned(directory, f".{pattern.partition('*')[0]}*.partial*")
        for path in directory.glob(pattern):
            with suppress(OSError):
                status = path.stat()
                kept.append((status.st_mtime, status.st_size, path))
    total = sum(size for _, size, _ in kept)
    for _, size, path in sorted(kept):
        if total <= allowed:
            break
        if path != newest:
            with suppress(OSError):
                path.unlink()
                total -= size


def _warn_once(what: str) -> None:
    if what not in WARNED:
        WARNED.add(what)
        said = f"{what}: what is computed is not kept for the next time; WIREWEAR_CACHE names a folder."
        warnings.warn(KeptNothingWarning(said), stacklevel=3)
