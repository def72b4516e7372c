"""How a delimited text is laid out, guessed from its first lines: encoding, delimiter, decimal sign, header, units."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from wirewear.errors import RecordError
from wirewear.files.delimited import Layout
from wirewear.files.reading import read_bytes
from wirewear.quantity import FIELD_UNITS, UNITS_PER_LENGTH

#: Lines that are looked at.
FIRST_LINES = 60

_NUMBER = r"[-+]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d+)?"


class NoTableError(RecordError):
    """A text holds no table of numbers."""


@dataclass(frozen=True)
class GuessedLayout:
    """A layout with the names of its columns, and the units where a line or the names tell them ("" where not)."""

    layout: Layout
    names: tuple[str, ...]
    units: tuple[str, ...]


def guessed_layout(path: Path) -> GuessedLayout:
    """How a text file with a table of numbers is laid out.

    Raises:
        RecordError: the file cannot be read.
        NoTableError: no table of numbers is found in it.
    """
    data = read_bytes(path, RecordError)
    encoding = _encoding(data)
    lines = data.decode(encoding, errors="replace").replace("\r\n", "\n").replace("\r", "\n").split("\n")[:FIRST_LINES]
    # The last line read may be cut off; blank lines tell nothing.
    found = [_table(lines, delimiter, decimal) for delimiter in ("\t", ";", ",", None) for decimal in (".", ",")]
    best = max(found, key=lambda table: table.score)
    if best.score <= 0:
        raise NoTableError(f"{path}: no table of numbers is found in its first {FIRST_LINES} lines.")
    names, names_line, after = _names(lines, best)
    layout = Layout(
        delimiter=best.delimiter,
        decimal=best.decimal,
        encoding=encoding,
        header_lines=names_line if names else best.first,
        names_line=bool(names),
        lines_after_names=after,
    )
    below = _fields(lines[names_line + 1], best.delimiter) if after else []
    units = tuple(_unit(name, below[place] if place < len(below) else "") for place, name in enumerate(names))
    return GuessedLayout(layout, names, units)


def _encoding(data: bytes) -> str:
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8-sig" if data.startswith(b"\xef\xbb\xbf") else "utf-8"


@dataclass(frozen=True)
class _Table:
    delimiter: str | None
    decimal: str
    first: int
    width: int
    score: float


def _table(lines: list[str], delimiter: str | None, decimal: str) -> _Table:
    """The longest run of lines with one number of fields, two at least, that are all numbers with this decimal sign."""
    if delimiter == decimal:
        return _Table(delimiter, decimal, 0, 0, 0.0)
    number = re.compile(_NUMBER.replace("[.,]", re.escape(decimal)))
    widths = []
    for line in lines:
        fields = _fields(line, delimiter)
        while fields and not fields[-1]:
            fields.pop()
        sound = len(fields) >= 2 and all(not field or number.fullmatch(field) for field in fields)
        widths.append(len(fields) if sound and any(fields) else 0)
    if not any(widths):
        return _Table(delimiter, decimal, 0, 0, 0.0)
    width = Counter(width for width in widths if width).most_common(1)[0][0]
    rows = [place for place, own in enumerate(widths) if own == width]
    # Of readings that explain as many lines, that with more decimal fractions is likelier than that with more columns.
    fractions = sum(decimal in field for place in rows[:5] for field in _fields(lines[place], delimiter))
    return _Table(
        delimiter, decimal, rows[0], width, len(rows) + 0.01 * min(fractions, 50) + (0.5 if delimiter else 0.0)
    )


def _fields(line: str, delimiter: str | None) -> list[str]:
    return [field.strip().strip('"').strip() for field in line.split(delimiter)]


def _names(lines: list[str], table: _Table) -> tuple[tuple[str, ...], int, int]:
    """Names of the columns, the line on which they stand, and lines between them and the numbers."""
    candidates = []
    for place in range(table.first - 1, max(table.first - 4, -1), -1):
        fields = _fields(lines[place], table.delimiter)
        named = any(re.search(r"[^\W\d_]", field) for field in fields) or _are_units(fields)
        if len(fields) >= table.width and named:
            candidates.append((place, fields))
        else:
            break
    if not candidates:
        return (), 0, 0
    place, fields = candidates[0]
    if len(candidates) > 1 and _are_units(fields):
        place, fields = candidates[1]
    return tuple(fields), place, table.first - place - 1


def _are_units(fields: list[str]) -> bool:
    """Whether a line holds units: short, in brackets or not, and none of the kind that names a column."""
    bare = [field.strip("[]() ") for field in fields if field]
    return bool(bare) and all(len(unit) <= 6 and (unit in KNOWN_UNITS or unit in {"-", "–", ""}) for unit in bare)


#: Units that loggers write, as they write them.
KNOWN_UNITS = frozenset(
    unit for table in (FIELD_UNITS, UNITS_PER_LENGTH) for units in table.values() for unit in units
) | frozenset(("V", "mV", "sec", "MPa", "Hz", "°C", "%", "rad"))


def _unit(name: str, below: str) -> str:
    """The unit of a column: in the line below its name, or at the name's end."""
    if bare := below.strip("[]() "):
        return bare
    match = re.search(r"[\[(]\s*([^\s\[\]()]+)\s*[\])]\s*$", name) or re.search(r"[_\s/]([^\s_/]+)$", name)
    return match[1] if match and match[1] in KNOWN_UNITS else ""
