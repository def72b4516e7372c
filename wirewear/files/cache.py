"""The folder of what is kept to be used again, within a size: condensed wires unused for longest go first."""

from __future__ import annotations

import os
import shutil
from contextlib import suppress
from pathlib import Path
from time import time

#: Gigabytes of wires that are kept, unless WIREWEAR_CACHE_GB says otherwise.
DEFAULT_GB = 10.0

#: Nothing that is kept takes a day to be made: what is unfinished after one belongs to nobody.
_ABANDONED_s = 86_400.0


def cache_directory() -> Path:
    """WIREWEAR_CACHE if set, else the user's cache folder."""
    chosen = os.environ.get("WIREWEAR_CACHE")
    if chosen:
        return Path(chosen)
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "wirewear"


def allowed_bytes() -> float:
    """The size from WIREWEAR_CACHE_GB, or the default one if that is no number of zero or more."""
    with suppress(ValueError):
        chosen = float(os.environ.get("WIREWEAR_CACHE_GB", DEFAULT_GB))
        if chosen >= 0.0:
            return 1e9 * chosen
    return 1e9 * DEFAULT_GB


def mark_used(path: Path) -> None:
    """Note that a kept wire is of use now."""
    with suppress(OSError):
        os.utime(path)


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
    """Delete wires until the rest takes at most `allowed` bytes, least recently used first, `newest` never.

    Files that go or cannot be deleted meanwhile are left to whoever holds them.
    """
    remove_abandoned(directory, ".wire-*.partial*")
    kept = []
    for path in directory.glob("wire-*.npz"):
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
