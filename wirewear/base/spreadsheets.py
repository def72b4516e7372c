"""Spreadsheets (.xlsx) converted to text with a tab between cells, so that one reader handles both."""

import re
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import date, datetime, time
from io import BytesIO
from pathlib import Path
from typing import Any

from wirewear.base.errors import RecordError
from wirewear.base.memory import free_memory, require_room
from wirewear.base.words import counted

MOST_ROWS, MOST_COLUMNS = 1_048_576, 16_384  #: Of a sheet, in any spreadsheet program.

#: Cells that are left out in the file are filled up on reading: so many do no harm, or so many for each that is there.
HARMLESS_EMPTY, MOST_EMPTY = 5_000_000, 20

#: What stands for a formula of which the file holds no value.
UNCOMPUTED = "=?"

SHEET = "Sheet: "  #: Begins the line above each sheet where all of a workbook are read as one text.

_OLD_EXCEL = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
_CHUNK = 1 << 20

#: Attributes of a row; attributes and contents of a cell.
_PLACE = re.compile(rb"<(?:\w+:)?(?:row\b([^>]*)>|c\b([^>]*?)(?:/>|>(.*?)</(?:\w+:)?c>))", re.DOTALL)
_REFERENCE = re.compile(rb'\sr="([A-Z]*)(\d+)"')
_FORMULA, _VALUE = re.compile(rb"<(?:\w+:)?f[\s/>]"), re.compile(rb"<(?:\w+:)?(?:v>[^<]|is>)")


@dataclass(frozen=True)
class Sheet:
    """Sheet of a spreadsheet: its title, how many numbers it holds, and its rows as lines of text."""

    title: str
    numbers: int
    lines: list[str]


def is_spreadsheet(data: bytes) -> bool:
    """True if these bytes are of an .xlsx file, whatever its name."""
    return data.startswith(b"PK\x03\x04") and b"xl/workbook" in data


def sheets_of(data: bytes, path: Path) -> list[Sheet]:
    """Sheets of a spreadsheet that hold numbers, in their order.

    Raises RecordError if the file cannot be read, or would take more memory or cells than it may.
    """
    import openpyxl

    try:
        with zipfile.ZipFile(BytesIO(data)) as parts:
            require_room(path, sum(part.file_size for part in parts.infolist()), RecordError)
            names = [name for name in parts.namelist() if re.fullmatch(r"xl/worksheets/[^/]+\.xml", name)]
            uncomputed = {name: _weighed(parts, name, path) for name in names}
        book = openpyxl.load_workbook(BytesIO(data), read_only=True, data_only=True)
        sheets = [
            _sheet(sheet, path, uncomputed.get(str(vars(sheet)["_worksheet_path"]).lstrip("/"), set()))
            for sheet in book.worksheets
        ]
    except RecordError:
        raise
    except Exception as problem:
        # A dozen exception types, depending on the byte that is wrong.
        reason = " ".join(str(problem).split())[:120] or type(problem).__name__
        raise RecordError(f"{path} cannot be read as a spreadsheet ({reason}).") from problem
    found = [sheet for sheet in sheets if sheet.numbers]
    if not found:
        raise RecordError(f"{path}: no sheet holds numbers.")
    return found


def largest(sheets: list[Sheet]) -> Sheet:
    """Sheet with the most numbers."""
    return max(sheets, key=lambda sheet: sheet.numbers)


def sheet_text(sheets: list[Sheet]) -> bytes:
    """The sheet with the most numbers as UTF-8 text: its rows as lines, with tabs between cells."""
    return "\n".join([*largest(sheets).lines, ""]).encode()


def workbook_text(sheets: list[Sheet]) -> bytes:
    """All sheets as UTF-8 text, one after another: a line of `SHEET` and the sheet's title, then its rows as lines."""
    return "\n".join([line for sheet in sheets for line in (SHEET + sheet.title, *sheet.lines)] + [""]).encode()


def left_out(path: Path, sheets: list[Sheet], names: str | None = None) -> tuple[str, ...]:
    """One sentence, in a tuple, that names the sheets that are not read; an empty tuple if there are none.

    names: line of column names that the sheets to be read contain; None: only the largest sheet is read.
    """
    left = [
        repr(one.title) for one in sheets if (one is not largest(sheets) if names is None else names not in one.lines)
    ]
    return (
        (f"{path.name}: of its sheets, {', '.join(left)} {'are' if len(left) > 1 else 'is'} not read",) if left else ()
    )


def refuse_other_sheets(data: bytes, path: Path) -> None:
    """Raise RecordError, with a remedy, if the bytes are of another spreadsheet format (old Excel, OpenDocument)."""
    if data.startswith(_OLD_EXCEL) or data[30:80].startswith(b"mimetypeapplication/vnd.oasis.opendocument.spreadsheet"):
        raise RecordError(f"{path} is a spreadsheet of a kind that is not read: save it as .xlsx or as CSV.")


def _weighed(parts: zipfile.ZipFile, name: str, path: Path) -> set[tuple[int, int]]:
    """Row and column, counted from 1, of the formulas in a sheet that have no stored value.

    Raises RecordError if its cells exceed a sheet's limits or lie too far apart.
    """
    uncomputed: set[tuple[int, int]] = set()
    row = column = last = cells = places = 0
    for attributes, of_cell, contents in _tags(parts, name):
        reference = _REFERENCE.search(attributes if of_cell is None else of_cell)
        if of_cell is None:
            places += last
            before, last, column = row, 0, 0
            row = int(reference[2][:20]) if reference else row + 1
            places += max(row - before - 1, 0)
        else:
            column = _number(reference[1]) if reference and reference[1] else column + 1
            last, cells = max(last, column), cells + 1
            if contents is not None and _FORMULA.search(contents) and not _VALUE.search(contents):
                uncomputed.add((row, column))
        if row > MOST_ROWS or column > MOST_COLUMNS:
            what, most = ("row", MOST_ROWS) if row > MOST_ROWS else ("column", MOST_COLUMNS)
            raise RecordError(
                f"{path}: {name} has a {what} of number {counted(max(row, column))}, where a sheet has at most "
                f"{counted(most)}: it is damaged, or made to fill the memory."
            )
        if places + last > HARMLESS_EMPTY + MOST_EMPTY * cells:
            raise RecordError(
                f"{path}: {name} spreads {counted(cells)} cells over more than {counted(places + last)} places, up to "
                f"row {counted(row)}: delete what stands far from the numbers, or save the sheet as CSV."
            )
    return uncomputed


def _tags(parts: zipfile.ZipFile, name: str) -> Iterator[tuple[bytes | Any, ...]]:
    """For each row or cell, in order: attributes of the row, attributes of the cell, contents of the cell; None if
    absent.
    """
    with parts.open(name) as stream:
        rest = b""
        while chunk := stream.read(_CHUNK):
            rest += chunk
            # What stands before the last row that begins is whole.
            end = rest.rfind(b"<", 0, max(rest.rfind(b"<row"), rest.rfind(b":row "), 0) + 1)
            yield from (match.group(1, 2, 3) for match in _PLACE.finditer(rest, 0, max(end, 0)))
            rest = rest[max(end, 0) :]
    yield from (match.group(1, 2, 3) for match in _PLACE.finditer(rest))


def _number(letters: bytes) -> int:
    number = 0
    for letter in letters[:8]:
        number = 26 * number + letter - 64
    return number


def _sheet(sheet: Any, path: Path, uncomputed: set[tuple[int, int]]) -> Sheet:
    sheet.reset_dimensions()
    # Bytes that a cell takes in memory at most while its sheet becomes text.
    most = free_memory() / 200
    cells, numbers = 0, len(uncomputed)
    lines = []
    for number, row in enumerate(sheet.iter_rows(values_only=True), 1):
        # Lines and cells that are left out in the file are filled up on reading.
        cells += len(row) + 1
        if cells > most:
            raise RecordError(f"{path}: a sheet of more than {counted(most)} cells takes more memory than is free.")
        numbers += sum(isinstance(value, int | float) for value in row)
        spelled = [_spelled(value) for value in row]
        if uncomputed:
            spelled = [UNCOMPUTED if (number, n) in uncomputed else one for n, one in enumerate(spelled, 1)]
        lines.append("\t".join(spelled).rstrip("\t"))
    return Sheet(sheet.title, numbers, lines)


def _spelled(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, datetime | date | time):
        return value.isoformat(" ") if isinstance(value, datetime) else value.isoformat()
    text = " ".join(str(value).split())
    # A number that was pasted as text keeps the comma of its country.
    return text.replace(",", ".") if re.fullmatch(r"[-+]?\d+,\d+(?:[eE][-+]?\d+)?", text) else text
