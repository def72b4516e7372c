"""Places that results go to: tried before anything is computed."""

from __future__ import annotations

import errno
import os
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryFile

from wirewear.base.errors import RunError
from wirewear.base.writing import is_special, link_followed, name_beside, open_number, writing


def prepared_folder(path: Path) -> Path:
    """Make an output folder if need be, and see that files can be written there.

    Raises:
        RunError: the folder cannot be made, or takes no files.
    """
    with writing(RunError, f"the output folder {path} cannot be used"):
        path.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=path):
            return path


def usable_folder(path: Path) -> Path:
    """See that an output folder takes files, or could be made and would; one that is not there is not left there.

    Raises:
        RunError: it cannot be made, or takes no files.
    """
    with writing(RunError, f"the output folder {path} cannot be used"):
        made = _missing(path)
    try:
        return prepared_folder(path)
    finally:
        for folder in made:
            # Not all may have been made, and somebody else may have put something there meanwhile.
            with suppress(OSError):
                folder.rmdir()


def usable_file(path: Path) -> Path:
    """See that a file can be written or replaced, its folder made if need be; nothing is left or changed.

    Raises:
        RunError: it cannot.
    """
    with writing(RunError, f"{path} cannot be written"):
        if is_special(path):
            if (number := open_number(path)) is not None:
                os.close(os.dup(number))
            elif not os.access(path, os.W_OK):
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
            return path
        place = link_followed(path)
    usable_folder(place.parent)
    with writing(RunError, f"{path} cannot be written"):
        if path.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        # What is too long for a name is found by looking for it, in a folder that is there.
        folder = next(above for above in path.parents if above.is_dir())
        _missing(folder / name_beside(path).name)
    return path


def _missing(path: Path) -> list[Path]:
    """What is not there of a path, the innermost first; OSError where nothing can be."""
    try:
        path.stat()
    except FileNotFoundError:
        return [path, *_missing(path.parent)]
    return []
