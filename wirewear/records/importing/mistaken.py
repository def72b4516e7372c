"""What is taken for a mapping file and is another one: said as what it is, with the command that takes it."""

import re
from pathlib import Path

from wirewear.base.errors import RecordError
from wirewear.base.reading import read_text
from wirewear.base.recognised import Held, require_no_other

#: What stands in a guessed mapping for what only the user can tell.
OPEN = "?"

_OPEN_LINE = re.compile(r"^\s*(\w+) *=[^#\n]*[\"']\?[\"']")


def open_lines(text: str) -> list[tuple[int, str]]:
    """Numbers of the lines of a mapping, from 1, that are left open, and the key of each."""
    found = ((number, _OPEN_LINE.match(line)) for number, line in enumerate(text.splitlines(), start=1))
    return [(number, match[1]) for number, match in found if match]


def lines_to_fill_in(text: str) -> str:
    """``line 6 (diameter_mm) and line 14 (displacement_um)`` of a mapping; empty where nothing is left open."""
    *most, last = [f"line {number} ({key})" for number, key in open_lines(text)] or [""]
    return f"{', '.join(most)} and {last}" if most else last


def require_mapping(path: Path) -> None:
    """See that a file is no study, no sweep, no record and none of a laboratory's own files, and is filled in.

    What else is wrong within a mapping is left to whoever reads it.

    Raises:
        RecordError: it is; one sentence that says what it is.
    """
    require_no_other(path, RecordError, Held.MAPPING)
    if path.is_file() and (left := lines_to_fill_in(read_text(path, RecordError))):
        raise RecordError(f'{path} is not filled in: put what is right in place of "{OPEN}" in {left}.')
