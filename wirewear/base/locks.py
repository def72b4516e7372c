"""Locks on output folders, so that one process at a time writes to a folder.

The lock is the kernel's, on a file in the folder, and ends with the process that holds it. The file says who holds the
folder, and remains if that process did not finish.
"""

import errno
import fcntl
import json
import os
import socket
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from wirewear.base.errors import RunError
from wirewear.base.files import require_unchanged, with_checksum
from wirewear.base.writing import prepared_folder, writing

LOCK_FILE_NAME = ".wirewear-lock"


@contextmanager
def occupied(folder: Path, what: str, **noted: str) -> Iterator[Mapping[str, object]]:
    """Lock a folder, created if missing, for the enclosed work; `what` names the work in messages of others.

    Yields what the last holder noted, if it did not finish; else an empty mapping. `noted` is written to the lock file,
    which remains only if something was noted and the work ends in an error. Raises RunError if another process holds
    the folder, or it cannot be written to.
    """
    path = prepared_folder(folder) / LOCK_FILE_NAME
    with writing(RunError, f"the output folder {folder} cannot be used"):
        descriptor = _locked(path, folder)
        before = _noted(descriptor)
        held = with_checksum({"what": what, "process": os.getpid(), "host": socket.gethostname(), **noted})
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, json.dumps(held).encode(), 0)
        os.fsync(descriptor)
    # For whoever goes on with it.
    left = bool(noted)
    try:
        yield before
        left = False
    finally:
        if not left:
            # Whoever opened the file meanwhile finds it gone once the lock is free, and makes a new one.
            with suppress(OSError):
                path.unlink()
        os.close(descriptor)


def last_noted(folder: Path) -> Mapping[str, object]:
    """The note in a folder's lock file by the process that holds it, or held it and did not finish; may be empty."""
    try:
        descriptor = os.open(folder / LOCK_FILE_NAME, os.O_RDONLY | os.O_NOFOLLOW)
    except OSError:
        return {}
    try:
        return _noted(descriptor)
    finally:
        os.close(descriptor)


def clear_abandoned(folder: Path) -> None:
    """Delete the lock file of a killed process, if no process holds the folder."""
    with suppress(OSError):
        descriptor = os.open(folder / LOCK_FILE_NAME, os.O_RDWR | os.O_NOFOLLOW)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            (folder / LOCK_FILE_NAME).unlink()
        finally:
            os.close(descriptor)


def _locked(path: Path, folder: Path) -> int:
    """File descriptor of the lock file, locked where the file system supports locks."""
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as problem:
            holder = _noted(descriptor)
            if problem.errno in (errno.EWOULDBLOCK, errno.EACCES):
                os.close(descriptor)
                who = f" ({holder['what']}, process {holder['process']} on {holder['host']})" if holder else ""
                raise RunError(
                    f"another command is writing to {folder}{who}: choose another --output, or wait for its end."
                ) from None
            return descriptor
        if os.fstat(descriptor).st_nlink:
            return descriptor
        os.close(descriptor)


def _noted(descriptor: int) -> Mapping[str, object]:
    try:
        found = json.loads(os.pread(descriptor, 65_536, 0))
        require_unchanged(found, "the note", RunError)
    except (OSError, ValueError, TypeError, RecursionError, RunError):
        return {}
    return found if isinstance(found, dict) and {"what", "process", "host", "sha256"} <= found.keys() else {}
