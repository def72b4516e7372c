"""Delimited text in any encoding, with any delimiter and decimal sign: rows of fields below a line of column names.

Columns of numbers are read by polars. If it meets anything unusual, the same bytes are read again line by line, which
either names the place of the first mistake or reads what the fast reader could not.
"""

import codecs
import csv
import hashlib
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import islice
from pathlib import Path

import numpy as np

from geometry.arrays import Array, IntArray
from wirewear.base.blocks import counts_in, is_comment, numbered
from wirewear.base.errors import RecordError
from wirewear.base.files import read_bytes, utf8
from wirewear.base.naming import MISSING
from wirewear.base.spreadsheets import (
    UNCOMPUTED,
    Sheet,
    is_spreadsheet,
    left_out,
    refuse_other_sheets,
    sheet_text,
    sheets_of,
    workbook_text,
)
from wirewear.base.words import shown
from wirewear.base.written_numbers import in_doubt, number_of, seconds_of, ungrouped

_UTF8 = "utf-8"


#: Of what numbers in words have, and numbers have not.
_LABEL = re.compile(r"[^\W\d_]{2}|[^\W\d_]\W*[=\d]|\d\s?[kKM]$")


@dataclass(frozen=True)
class DelimitedLayout:
    """Layout of a delimited text."""

    delimiter: str | None = ","  #: Delimiter of fields; None for any white space.
    decimal: str = "."  #: Decimal sign, "." or ",".
    encoding: str = _UTF8
    header_lines: int = 0  #: Number of lines before the line of names.
    names_line: bool = True  #: True if a line names the columns.
    lines_after_names: int = 0  #: Number of lines between names and numbers, such as one of units.
    ragged: bool = False  #: True if rows may be shorter than the line of names.
    most_rows: int | None = None  #: Number of lines of numbers that are read; None: all.
    blocks: bool = False  #: True if several tables are read, numbered by words above each (see `blocks`).

    @property
    def line_of_names(self) -> int:
        return self.header_lines + 1

    @property
    def lines_before_rows(self) -> int:
        return self.header_lines + self.names_line + self.lines_after_names


CSV = DelimitedLayout()


@dataclass(frozen=True)
class Numbers:
    """Columns (n,) of numbers by name, NaN for empty fields, and the lines of the file on which the n rows stand:
    consecutive ones from `first_line`, unless line_numbers (n,) lists them. Both count from 1.
    """

    columns: dict[str, Array]
    first_line: int
    line_numbers: IntArray | None = None

    def line(self, row: int) -> int:
        """Number of the file's line on which this row (from 0) stands, counted from 1."""
        return row + self.first_line if self.line_numbers is None else int(self.line_numbers[row])


@dataclass(frozen=True)
class DelimitedText:
    """Text read from `path`: `data` holds its bytes in UTF-8, with lines that end in a line feed."""

    path: Path
    data: bytes
    layout: DelimitedLayout

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the columns; empty if no line names them."""
        if not self.layout.names_line:
            return ()
        line = next(islice(self._lines(), self.layout.header_lines, None), "")
        return tuple(self._fields(line)) if line.strip() else ()

    def rows(self) -> Iterator[tuple[int, list[str]]]:
        """Each row in order: the number of its line, counted from 1, and its fields. Blank lines and comments are
        skipped.

        Raises RecordError if quotation marks cannot be read.
        """
        number = self.layout.lines_before_rows + 1
        lines = islice(self._lines(), number - 1, None)
        if b'"' not in self.data or self.layout.delimiter is None:
            rows = ((n, line) for n, line in enumerate(lines, start=number) if line.strip() and not is_comment(line))
            yield from ((n, self._fields(line)) for n, line in rows)
        else:
            yield from self._quoted(("" if is_comment(line) else line for line in lines), number)

    def numbers(self, places: Mapping[str, int], *, as_logged: bool = False, clock: str | None = None) -> Numbers:
        """Columns of numbers by name; places: the index (from 0) of each name's column.

        as_logged: True if rows may differ in length, words such as "No Data" stand for missing values, and the columns
        named "cycle" and "repeat" may hold their numbers in words such as "Cycle 5000". clock: name of a column that
        may hold times of day, which become seconds, going on past midnight; None: none does. Raises RecordError, naming
        line and column, if a field is missing or not a number.
        """
        found = self._fast(places) or self._slow(places, as_logged, clock)
        for values in found.columns.values() if as_logged else ():
            # What instruments send beyond their range, or for no number (SCPI-1999, 7.2.1.4).
            values[np.abs(values) >= 9.9e37] = math.nan
        return found

    def _lines(self) -> Iterator[str]:
        return (line.decode(_UTF8) for line in self._byte_lines())

    def _byte_lines(self) -> Iterator[bytes]:
        start = 0
        while start <= len(self.data):
            end = self.data.find(b"\n", start)
            end = len(self.data) if end < 0 else end
            yield self.data[start:end]
            start = end + 1

    def _fields(self, line: str) -> list[str]:
        separator = self.layout.delimiter
        if separator is None or '"' not in line:
            return fields_of(line, separator)
        return next((fields for _, fields in self._quoted([line], 1)), [])

    def _quoted(self, lines: Iterable[str], first: int) -> Iterator[tuple[int, list[str]]]:
        """Line number and fields of rows in which a quoted field may hold the delimiter or span several lines."""
        delimiter = self.layout.delimiter or ","
        reader, before = csv.reader((f"{line}\n" for line in lines), delimiter=delimiter, skipinitialspace=True), 0
        try:
            for fields in reader:
                if len(fields) > 1 or any(field.strip() for field in fields):
                    yield first + before, [field.strip() for field in fields]
                before = reader.line_num
        except csv.Error as problem:
            raise RecordError(f"{self.path}, line {first + before}: the line cannot be read ({problem}).") from None

    def _fast(self, places: Mapping[str, int]) -> Numbers | None:
        """Columns read by polars; None if the text is not simple enough for it."""
        import polars as pl

        layout, start = self.layout, self._start_of_rows()
        if start is None or layout.delimiter is None or layout.delimiter == layout.decimal:
            return None
        delimiter = layout.delimiter.encode()
        # Beside decimal commas polars reads points as decimal signs, too, where they part thousands.
        perhaps_blank = delimiter.isspace() and self.data.find(b"\n" + delimiter, max(start - 1, 0)) >= 0
        if perhaps_blank or (layout.decimal == "," and self.data.find(b".", start) >= 0):
            return None
        end = self.data.find(b"\n", start)
        width = self.data.count(delimiter, start, len(self.data) if end < 0 else end) + 1
        if width == 1 or width <= max(places.values(), default=0) or (self.names and width != len(self.names)):
            return None
        schema = {str(i): pl.Float64() if i in places.values() else pl.String() for i in range(width)}
        try:
            frame = pl.read_csv(
                self.data,
                has_header=False,
                skip_lines=layout.lines_before_rows,
                schema=schema,
                columns=sorted(set(places.values())),
                separator=layout.delimiter,
                decimal_comma=layout.decimal == ",",
                quote_char=None,
                raise_if_empty=False,
            )
        except pl.exceptions.PolarsError:
            return None
        lines = self.data.count(b"\n", start) + (not self.data.endswith(b"\n"))
        # Short and empty lines would be filled up silently.
        if frame.height != lines or self.data.count(delimiter, start) != lines * (width - 1):
            return None
        columns = {
            name: frame[str(place)].fill_null(math.nan).to_numpy(writable=True) for name, place in places.items()
        }
        return Numbers(columns, layout.lines_before_rows + 1)

    def _start_of_rows(self) -> int | None:
        start = 0
        for _ in range(self.layout.lines_before_rows):
            start = self.data.find(b"\n", start) + 1
            if not start:
                return None
        return start

    def _slow(self, places: Mapping[str, int], as_logged: bool, clock: str | None) -> Numbers:
        values: dict[str, list[float]] = {name: [] for name in places}
        labels: dict[str, dict[int, str]] = {name: {} for name in ("cycle", "repeat") if as_logged and name in places}
        numbers, clocked, width = [], False, len(self.names)
        for number, fields in self.rows():
            width = width or len(fields)
            whole = not self.names or not (as_logged or self.layout.ragged)
            if len(fields) != width and (whole or any(fields[width:])):
                stated = f"{self.layout.line_of_names} names {width} columns"
                stated = stated if self.names else f"{self.layout.lines_before_rows + 1} has {width}"
                raise RecordError(
                    f"{self.path}, line {number}, column {min(len(fields), width)}: there are {len(fields)} fields "
                    f"where line {stated}."
                )
            numbers.append(number)
            for name, place in places.items():
                if name == clock and place < len(fields) and (seconds := seconds_of(fields[place])) is not None:
                    values[name].append(seconds)
                    clocked = True
                else:
                    absent = as_logged and place < len(fields) and MISSING.fullmatch(fields[place])
                    label = name in labels and place < len(fields) and _LABEL.search(fields[place])
                    if label:
                        labels[name][len(values[name])] = fields[place]
                    values[name].append(math.nan if absent or label else self._number(number, place, fields))
        for name, found in labels.items():
            different = list(dict.fromkeys(found.values()))
            counts = counts_in(different, name)
            if counts is None:
                word, line = different[0], numbers[next(iter(found))]
                raise RecordError(f"{self.path}, line {line}: {shown(word)} and the like number no {name}.")
            of_label = dict(zip(different, counts, strict=True))
            for row, label_of_row in found.items():
                values[name][row] = float(of_label[label_of_row])
        columns = {name: np.array(column, dtype=np.float64) for name, column in values.items()}
        if clock is not None and clocked:
            # Times of day go on past midnight.
            known = np.isfinite(columns[clock])
            columns[clock] = columns[clock].copy()
            columns[clock][known] = np.unwrap(columns[clock][known], period=86400.0)
        return Numbers(columns, self.layout.lines_before_rows + 1, np.array(numbers, dtype=np.int64))

    @cached_property
    def _shows_fractions(self) -> bool:
        """True if some number shows the decimal sign, so that the other sign can only separate thousands."""
        fraction = re.compile(rf"[-+]?\d+{re.escape(self.layout.decimal)}\d+")
        return any(fraction.fullmatch(field) and not in_doubt(field) for _, row in self.rows() for field in row)

    def _number(self, line: int, place: int, fields: list[str]) -> float:
        if place >= len(fields):
            raise RecordError(f"{self.path}, line {line}, column {place + 1}: the line has fewer columns.")
        text, comma = fields[place], self.layout.decimal == ","
        if not text:
            return math.nan
        # Python reads 1_000 as a thousand, which no logger means.
        certain = "_" not in text and (not in_doubt(text) or self.layout.decimal in text or self._shows_fractions)
        plain = ungrouped(text, self.layout.decimal)
        try:
            return float(plain.replace(",", ".") if comma else plain) if certain else float("")
        except ValueError:
            column = self.names[place] if place < len(self.names) else place + 1
            other = "." if comma else ","
            hint = f', or decimal = "{other}" is meant' if re.fullmatch(rf"[-+]?\d+[{other}]\d+", text) else ""
            if text == UNCOMPUTED:
                hint = ", but a formula without a value: open the file in a spreadsheet program and save it"
            raise RecordError(f"{self.path}, line {line}, column {column}: {shown(text)} is no number{hint}.") from None


def fields_of(line: str, delimiter: str | None) -> list[str]:
    """Fields of a line without their quotation marks; the delimiter None stands for any white space."""
    if delimiter is None:
        line = re.sub(r"no\s+data", "***", line, flags=re.IGNORECASE)
    elif '"' in line:
        # A field may be too long to be one.
        with suppress(csv.Error):
            return [field.strip() for field in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))]
    return [field.strip().strip('"').strip() for field in line.split(delimiter)]


def contents_of(path: Path) -> tuple[bytes, list[Sheet]]:
    """Bytes of a file, and an empty list; of a spreadsheet the text (UTF-8) of the sheet with the most numbers, and all
    its sheets that hold numbers.

    Raises RecordError if the file cannot be read.
    """
    data = read_bytes(path, RecordError)
    if is_spreadsheet(data):
        sheets = _sheets_of(path, hashlib.sha256(data).digest())
        return sheet_text(sheets), sheets
    refuse_other_sheets(data, path)
    return data, []


def sheets_left_out(path: Path, layout: DelimitedLayout) -> tuple[str, ...]:
    """One sentence that names the sheets of a spreadsheet that `read_delimited` does not read; empty if there are none.

    Raises RecordError if the file cannot be read.
    """
    _, sheets = contents_of(path)
    if not layout.blocks:
        return left_out(path, sheets)
    lines = workbook_text(sheets).decode().split("\n")
    return left_out(path, sheets, lines[layout.header_lines] if layout.header_lines < len(lines) else None)


@lru_cache(maxsize=1)
def _sheets_of(path: Path, _digest: bytes) -> list[Sheet]:
    """Sheets of a spreadsheet file; the last result is kept, by the digest of the contents."""
    return sheets_of(read_bytes(path, RecordError), path)


def read_delimited(path: Path, layout: DelimitedLayout = CSV) -> DelimitedText:
    """Delimited text of a file; of a spreadsheet, the sheet with the most numbers, or with `layout.blocks` all sheets.

    Raises RecordError if the file cannot be read, or is not text in the layout's encoding.
    """
    data, sheets = contents_of(path)
    if sheets:
        data = workbook_text(sheets) if layout.blocks else data
        layout = replace(layout, delimiter="\t", decimal=".", encoding=_UTF8)
        return DelimitedText(path, _first_rows(data, layout), layout)
    if codecs.lookup(layout.encoding).name not in (_UTF8, "utf-8-sig"):
        try:
            data = data.decode(layout.encoding).encode()
        except UnicodeError as problem:
            raise RecordError(f"{path} cannot be read as text in {layout.encoding} ({problem}).") from None
    elif not data.isascii():
        utf8(data, path, RecordError)
    data = data.removeprefix(codecs.BOM_UTF8)
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return DelimitedText(path, _first_rows(data, layout), layout)


def repeated_heads(lines: Sequence[str], layout: DelimitedLayout) -> list[int]:
    """Indices of the lines, of the first head's height, that repeat the head of a table which goes on below them: some
    column, as of time, never falls and rises in all.

    Empty if there are none, or the tables below them are others.
    """
    height = layout.lines_before_rows - layout.header_lines
    head = list(lines[layout.header_lines : layout.lines_before_rows])
    if not layout.names_line or not head or not head[0].strip():
        return []
    starts = [n for n, line in enumerate(lines) if line == head[0] and lines[n : n + height] == head]
    if len(starts) < 2 or starts[0] != layout.header_lines:
        return []
    places: list[int] = []
    for start, after in zip(starts, [*starts[1:], len(lines)], strict=True):
        rows = [n for n in range(start + height, after) if lines[n].strip()]
        places += [rows[0], rows[len(rows) // 2], rows[-1]] if rows else []
    fields = [fields_of(lines[n], layout.delimiter) for n in places]
    numbers = [[number_of(field, layout.decimal) for field in row] for row in fields if len(row) == len(fields[0])]
    steps = np.diff(np.array(numbers), axis=0)
    goes_on = len(numbers) == len(places) and bool(((steps >= 0.0).all(axis=0) & (steps[2::3] > 0.0).all(axis=0)).any())
    return [start + n for start in starts[1:] for n in range(height)] if goes_on else []


def _first_rows(data: bytes, layout: DelimitedLayout) -> bytes:
    if layout.blocks:
        lines = data.decode(_UTF8).split("\n")
        head = layout.header_lines
        return "\n".join(numbered(lines, head, layout.delimiter)).encode() if head < len(lines) else data
    if layout.most_rows is None:
        names = b"\n" + b"".join(data.split(b"\n", layout.header_lines + 1)[layout.header_lines : -1]) + b"\n"
        if not layout.names_line or data.count(names) < 1 + (layout.header_lines > 0):
            return data
        lines = data.decode(_UTF8).split("\n")
        for place in repeated_heads(lines, layout):
            lines[place] = ""
        return "\n".join(lines).encode()
    ends = np.flatnonzero(np.frombuffer(data, dtype=np.uint8) == ord("\n"))
    last = layout.lines_before_rows + layout.most_rows
    return data[: int(ends[last - 1]) + 1] if last <= ends.size else data
