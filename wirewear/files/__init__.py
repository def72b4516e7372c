"""Files: written in one step or not at all, and read with one sentence for every mistake."""

from wirewear.files.folders import prepared_folder, usable_file, usable_folder
from wirewear.files.writing import (
    folder_in_one_step,
    in_one_step,
    is_special,
    temporary_folder,
    why_not_written,
    write_bytes,
    write_text,
    writing,
)

__all__ = [
    "folder_in_one_step",
    "in_one_step",
    "is_special",
    "prepared_folder",
    "temporary_folder",
    "usable_file",
    "usable_folder",
    "why_not_written",
    "write_bytes",
    "write_text",
    "writing",
]
