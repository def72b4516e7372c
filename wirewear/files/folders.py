"""Folders that results go to: made and tried before anything is computed."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryFile

from wirewear.errors import RunError
from wirewear.files.writing import writing


def prepared_folder(path: Path) -> Path:
    """Make an output folder if need be, and see that files can be written there.

    Raises:
        RunError: the folder cannot be made, or takes no files.
    """
    with writing(RunError, f"the output folder {path} cannot be used"):
        path.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=path):
            return path
