"""Folders whose files are used without being computed again: nobody but their owner may be able to write there."""

from __future__ import annotations

import os
import stat
from pathlib import Path


def chosen_cache() -> Path:
    """The folder for what is kept: WIREWEAR_CACHE, else one in the user's cache folder; RuntimeError without a home."""
    chosen = os.environ.get("WIREWEAR_CACHE")
    return Path(chosen) if chosen else _users_cache() / "wirewear"


def private_folder(chosen: Path) -> Path:
    """The folder, made if need be; one of the user's own in it, where it is another's or others can write to it.

    Raises:
        OSError: neither can be written to.
    """
    chosen.mkdir(mode=0o700, parents=True, exist_ok=True)
    own = chosen if is_own(chosen) else chosen / f"user-{os.geteuid()}"
    own.mkdir(mode=0o700, exist_ok=True)
    if not is_own(own):
        raise PermissionError(f"{own} can be written to by others")
    if not os.access(own, os.R_OK | os.W_OK | os.X_OK):
        raise PermissionError(f"{own} can be neither read nor written")
    return own


def is_own(folder: Path, owner: int | None = None) -> bool:
    """Whether a folder belongs to this user, or to `owner`, and nobody else can write to it; OSError without one."""
    status = folder.lstat()
    belongs = status.st_uid in (os.geteuid(), owner)
    return stat.S_ISDIR(status.st_mode) and belongs and not status.st_mode & 0o022


def _users_cache() -> Path:
    stated = os.environ.get("XDG_CACHE_HOME", "")
    # The XDG specification has relative paths ignored.
    return Path(stated) if Path(stated).is_absolute() else Path.home() / ".cache"
