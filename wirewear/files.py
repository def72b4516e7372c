"""Folders that results go to: made and tried before anything is computed, and why one cannot be written to."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryFile

from wirewear.errors import RunError


def prepared_folder(path: Path) -> Path:
    """Make an output folder if need be, and see that files can be written there.

    Raises:
        RunError: the folder cannot be made, or takes no files.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=path):
            return path
    except OSError as error:
        raise RunError(f"the output folder {path} cannot be used: {why_not_written(error)}.") from None


def why_not_written(error: OSError) -> str:
    """Why something could not be written, as the end of a sentence."""
    if isinstance(error, FileExistsError):
        return "it is a file, not a folder"
    if isinstance(error, NotADirectoryError):
        return "a part of this path is a file, not a folder"
    return error.strerror or str(error)
