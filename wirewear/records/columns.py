"""Columns of numbers in a CSV file: read fast, each file once, and refused with line and column where they are wrong.

The fast reader is polars. Where it meets anything unusual, the same bytes are read again line by line: that either
finds the first mistake and names its place, or reads what the fast reader could not.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wirewear.errors import RecordError
from wirewear.quantity import shown

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Column:
    """A column of numbers from `low` to `high`; unless `complete`, an empty field or NaN is a value that is missing."""

    name: str
    low: float
    high: float
    whole: bool = False
    complete: bool = False
    optional: bool = False

    @property
    def kind(self) -> str:
        """What is allowed, in words."""
        return f"{'a whole' if self.whole else 'a'} number between {self.low:g} and {self.high:g}"


@dataclass(frozen=True)
class ColumnTable:
    """Columns (n,) of a file by name; `line_numbers` is None where row i stands on line i + 2."""

    path: Path
    columns: dict[str, Array]
    line_numbers: NDArray[np.int64] | None = None

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self.columns.values())))

    def line(self, row: int) -> int:
        """Line of the file on which a row stands."""
        return row + 2 if self.line_numbers is None else int(self.line_numbers[row])


def read_columns(path: Path, wanted: Sequence[Column]) -> ColumnTable:
    """The wanted columns of a CSV file whose first line names them, in any order; others are passed over.

    Raises:
        RecordError: the file cannot be read, lacks a column that is not optional, or holds a wrong value.
    """
    data = _bytes(path)
    names = _header(path, data)
    present = _present(path, names, wanted)
    table = _fast(path, data, names, present) or _line_by_line(path, data, names, present)
    if not table.rows:
        raise RecordError(f"{path}, line 2: there are no rows below the column names.")
    for column in present:
        _check(table, column)
    return table


def column_names(path: Path) -> list[str]:
    """Names in the first line of a CSV file.

    Raises:
        RecordError: the file cannot be read, or its first line names no columns.
    """
    return _header(path, _bytes(path))


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as problem:
        raise RecordError(f"{path} cannot be read ({problem.strerror or problem}).") from None


def _header(path: Path, data: bytes) -> list[str]:
    end = data.find(b"\n")
    first = data if end < 0 else data[:end]
    if not first.strip():
        what = "the file is empty" if not data.strip() else "the first line is empty"
        raise RecordError(f"{path}, line 1: {what}, where the names of the columns should stand.")
    try:
        text = first.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        raise RecordError(f"{path}, line 1, column {problem.start + 1}: this is not text in UTF-8.") from None
    names = [_unquoted(name) for name in text.split(",")]
    for place, name in enumerate(names):
        if name in names[:place]:
            raise RecordError(f"{path}, line 1: the column {shown(name)} is named twice.")
    return names


def _present(path: Path, names: Sequence[str], wanted: Sequence[Column]) -> list[Column]:
    missing = [column.name for column in wanted if column.name not in names and not column.optional]
    if not missing:
        return [column for column in wanted if column.name in names]
    hint = "; `wirewear import` turns other layouts into a record" if len(names) == 1 else ""
    stem = missing[0].rpartition("_")[0]
    similar = next((name for name in names if stem and name not in {c.name for c in wanted} and stem in name), None)
    if similar is not None:
        hint = f"; {shown(similar)} looks like it in another unit"
    raise RecordError(
        f"{path}, line 1: the column {missing[0]} is missing among {shown(','.join(names))}{hint}."
        if len(missing) == 1
        else f"{path}, line 1: the columns {', '.join(missing)} are missing among {shown(','.join(names))}{hint}."
    )


def _fast(path: Path, data: bytes, names: Sequence[str], present: Sequence[Column]) -> ColumnTable | None:
    """The columns by polars, or None where the file is not as plain as it expects."""
    import polars as pl

    places = {column.name: names.index(column.name) for column in present}
    schema = {str(i): pl.Float64() if i in places.values() else pl.String() for i in range(len(names))}
    try:
        frame = pl.read_csv(
            data,
            has_header=False,
            skip_lines=1,
            schema=schema,
            columns=sorted(places.values()),
            quote_char=None,
            raise_if_empty=False,
        )
    except pl.exceptions.PolarsError:
        return None
    lines = data.count(b"\n") + (not data.endswith(b"\n"))
    # Short and empty lines would be filled up silently.
    if frame.height != lines - 1 or data.count(b",") != lines * (len(names) - 1):
        return None
    columns = {name: frame[str(i)].fill_null(math.nan).to_numpy() for name, i in places.items()}
    return ColumnTable(path, columns)


def _line_by_line(path: Path, data: bytes, names: Sequence[str], present: Sequence[Column]) -> ColumnTable:
    values: list[list[float]] = [[] for _ in present]
    places = [names.index(column.name) for column in present]
    numbers: list[int] = []
    for number, line in _lines(path, data):
        fields = line.split(",")
        if len(fields) != len(names):
            raise RecordError(
                f"{path}, line {number}, column {min(len(fields), len(names))}: there are {len(fields)} fields "
                f"where line 1 names {len(names)} columns."
            )
        numbers.append(number)
        for column, place, into in zip(present, places, values, strict=True):
            into.append(_number(path, number, column, _unquoted(fields[place])))
    columns = {column.name: np.array(column_values) for column, column_values in zip(present, values, strict=True)}
    return ColumnTable(path, columns, np.array(numbers, dtype=np.int64))


def _lines(path: Path, data: bytes) -> Iterator[tuple[int, str]]:
    """Numbered lines below the first that are not blank."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        bad = data.count(b"\n", 0, problem.start) + 1
        raise RecordError(f"{path}, line {bad}: this is not text in UTF-8.") from None
    for number, line in enumerate(text.split("\n"), start=1):
        if number > 1 and line.strip():
            yield number, line


def _number(path: Path, line: int, column: Column, text: str) -> float:
    if not text:
        return math.nan
    try:
        # Python reads 1_000 as a thousand, which no logger means.
        return float(text) if "_" not in text else float("")
    except ValueError:
        raise RecordError(
            f"{path}, line {line}, column {column.name}: {shown(text)} is no number, where {column.kind} should stand."
        ) from None


def _unquoted(text: str) -> str:
    return text.strip().strip('"').strip()


def _check(table: ColumnTable, column: Column) -> None:
    values = table.columns[column.name]
    wrong = (values < column.low) | (values > column.high)
    if column.complete:
        wrong |= np.isnan(values)
    if column.whole:
        wrong |= values != np.floor(values)
    if not wrong.any():
        return
    row = int(np.argmax(wrong))
    value = values[row]
    found = "the value is missing" if np.isnan(value) else f"the value is {value:.12g}"
    raise RecordError(
        f"{table.path}, line {table.line(row)}, column {column.name}: {found}, where {column.kind} should stand."
    )
