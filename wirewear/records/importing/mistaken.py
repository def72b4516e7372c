"""What is taken for a mapping file and is another one: said as what it is, with the command that takes it."""

import re
from pathlib import Path

from wirewear.errors import RecordError
from wirewear.files.reading import read_text
from wirewear.files.toml import read_toml
from wirewear.records.reading import TABLE_FILE_NAME

#: Tables of a mapping that say where measured numbers are.
_SOURCES = ("loops", "evolution", "scars", "profiles")

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
    if (path / TABLE_FILE_NAME).is_file():
        raise RecordError(f"{path} is a record already: `wirewear check {path}` reads it.")
    if not path.is_file():
        return
    try:
        tables = read_toml(path, RecordError)
    except RecordError:
        if path.suffix == ".toml":
            raise
        raise RecordError(
            f"{path} is no mapping file, which says what a laboratory's files hold: `wirewear new --mapping {path}` "
            "begins one."
        ) from None
    if any(name in tables for name in _SOURCES):
        if left := lines_to_fill_in(read_text(path, RecordError)):
            raise RecordError(f'{path} is not filled in: put what is right in place of "{OPEN}" in {left}.')
        return
    if "files" in tables:
        raise RecordError(f"{path} belongs to a record already: `wirewear check {path.parent}` reads it.")
    if "vary" in tables:
        raise RecordError(f"{path} is a sweep, and no mapping of measured files: `wirewear sweep {path}` runs it.")
    if "kind" in tables or "friction" in _table(tables.get("contact")):
        raise RecordError(
            f"{path} is a study, and no mapping of measured files: `wirewear run {path}` simulates it, and `wirewear "
            "new --mapping FILES` begins a mapping."
        )


def _table(value: object) -> dict[str, object]:
    return value if isinstance(value, dict) else {}
