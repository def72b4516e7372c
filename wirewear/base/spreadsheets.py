"""Spreadsheets as text: the sheet with the most numbers, a tab between cells, so that one reader takes both."""

import re
import zipfile
from datetime import date, datetime, time
from io import BytesIO
from pathlib import Path
from typing import Any

from wirewear.base.budget import free_memory, require_room
from wirewear.base.errors import RecordError, counted

CELL_bytes = 200  #: What a cell takes in memory at most while its sheet becomes text, in bytes.

_OLD_EXCEL = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"


def is_spreadsheet(data: bytes) -> bool:
    """Whether a file's bytes are those of an .xlsx, whatever its name."""
    return data.startswith(b"PK\x03\x04") and b"xl/workbook" in data


def sheet_text(data: bytes, path: Path) -> bytes:
    """The sheet with the most numbers as lines of cells, in UTF-8.
    Raises RecordError if the file cannot be read, or holds more than the memory takes.
    """
    import openpyxl

    try:
        with zipfile.ZipFile(BytesIO(data)) as parts:
            require_room(path, sum(part.file_size for part in parts.infolist()), RecordError)
        book = openpyxl.load_workbook(BytesIO(data), read_only=True, data_only=True)
        sheets = [_lines(sheet, path) for sheet in book.worksheets]
    except RecordError:
        raise
    except Exception as problem:
        # A dozen exception types, depending on the byte that is wrong.
        reason = " ".join(str(problem).split())[:120] or type(problem).__name__
        raise RecordError(f"{path} cannot be read as a spreadsheet ({reason}).") from problem
    numbers, lines = max(sheets, key=lambda sheet: sheet[0], default=(0, []))
    if not numbers:
        raise RecordError(f"{path}: no sheet holds numbers.")
    return "\n".join([*lines, ""]).encode()


def refuse_other_sheets(data: bytes, path: Path) -> None:
    """Say of spreadsheets that are not read what would be. Raises RecordError if the bytes are those of one."""
    if data.startswith(_OLD_EXCEL) or data[30:80].startswith(b"mimetypeapplication/vnd.oasis.opendocument.spreadsheet"):
        raise RecordError(f"{path} is a spreadsheet of a kind that is not read: save it as .xlsx or as CSV.")


def _lines(sheet: Any, path: Path) -> tuple[int, list[str]]:
    sheet.reset_dimensions()
    most = free_memory() / CELL_bytes
    cells = numbers = 0
    lines = []
    for row in sheet.iter_rows(values_only=True):
        # Lines and cells that are left out in the file are filled up on reading.
        cells += len(row) + 1
        if cells > most:
            raise RecordError(f"{path}: a sheet of more than {counted(most)} cells takes more memory than is free.")
        numbers += sum(isinstance(value, int | float) for value in row)
        lines.append("\t".join(map(_spelled, row)).rstrip("\t"))
    return numbers, lines


def _spelled(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, datetime | date | time):
        return value.isoformat(" ") if isinstance(value, datetime) else value.isoformat()
    text = " ".join(str(value).split())
    # A number that was pasted as text keeps the comma of its country.
    return text.replace(",", ".") if re.fullmatch(r"[-+]?\d+,\d+(?:[eE][-+]?\d+)?", text) else text
