"""Columns of numbers in CSV files, with their allowed ranges. Errors name line and column."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from geometry.arrays import Array, IntArray
from wirewear.base.delimited import CSV, DelimitedLayout, DelimitedText, Numbers, read_delimited
from wirewear.base.errors import RecordError
from wirewear.base.words import shown


@dataclass(frozen=True)
class Column:
    """Column of numbers from `low` to `high`; empty fields and NaN are missing values.

    whole: whole numbers only. complete: no missing values. optional: the column may be absent.
    """

    name: str
    low: float
    high: float
    whole: bool = False
    complete: bool = False
    optional: bool = False

    @property
    def kind(self) -> str:
        return f"{'a whole' if self.whole else 'a'} number between {self.low:g} and {self.high:g}"

    def first_wrong(self, values: Array) -> int | None:
        """Index of the first of the values (n,) that is not allowed; None if all are."""
        wrong = (values < self.low) | (values > self.high)
        if self.complete:
            wrong |= np.isnan(values)
        if self.whole:
            wrong |= values != np.floor(values)
        return int(np.argmax(wrong)) if wrong.any() else None


@dataclass(frozen=True)
class ColumnTable:
    """Columns (n,) of a file by name. order: row of the file in which each row stood; None if unchanged."""

    path: Path
    columns: dict[str, Array]
    numbers: Numbers
    order: IntArray | None = None

    @property
    def rows(self) -> int:
        return len(next(iter(self.columns.values())))

    def line(self, row: int) -> int:
        """Number of the file's line, counted from 1, of the table's row `row`, counted from 0."""
        return self.numbers.line(row if self.order is None else int(self.order[row]))


def read_columns(path: Path, wanted: Sequence[Column]) -> ColumnTable:
    """Wanted columns of a CSV file whose first line names them, in any order; other columns are ignored.

    Raises RecordError if the file cannot be read, has no rows, lacks a column that is not optional, or holds a value
    that is not allowed.
    """
    text = read_delimited(path)
    names = _names(text)
    present = _present(f"{path}, line {CSV.line_of_names}", names, wanted)
    numbers = text.numbers({column.name: names.index(column.name) for column in present})
    table = ColumnTable(path, numbers.columns, numbers)
    if not table.rows:
        raise RecordError(f"{path}, line {CSV.lines_before_rows + 1}: there are no rows below the column names.")
    for column in present:
        _check(table, column)
    return table


def column_names(path: Path, layout: DelimitedLayout) -> tuple[str, ...]:
    """Names of a delimited text's columns in their order. Raises RecordError if the file cannot be read, or the line of
    names is empty or names a column twice.
    """
    return _names(read_delimited(path, layout))


def _names(text: DelimitedText) -> tuple[str, ...]:
    names = text.names
    where = f"{text.path}, line {text.layout.line_of_names}"
    if not names:
        ends = text.data.count(b"\n") < text.layout.header_lines
        what = (
            "the line is empty"
            if text.data.strip() and not ends
            else "the file ends before it"
            if ends
            else "the file is empty"
        )
        raise RecordError(f"{where}: {what}, where the names of the columns should stand.")
    for place, name in enumerate(names):
        if name in names[:place]:
            raise RecordError(f"{where}: the column {shown(name)} is named twice.")
    return names


def _present(where: str, names: Sequence[str], wanted: Sequence[Column]) -> list[Column]:
    missing = [column.name for column in wanted if column.name not in names and not column.optional]
    if not missing:
        return [column for column in wanted if column.name in names]
    hint = "; `wirewear import` turns other layouts into a record" if len(names) == 1 else ""
    stem = missing[0].rpartition("_")[0]
    similar = next((name for name in names if stem and name not in {c.name for c in wanted} and stem in name), None)
    if similar is not None:
        hint = f"; {shown(similar)} looks like it in another unit"
    raise RecordError(
        f"{where}: the column {missing[0]} is missing among {shown(','.join(names))}{hint}."
        if len(missing) == 1
        else f"{where}: the columns {', '.join(missing)} are missing among {shown(','.join(names))}{hint}."
    )


def _check(table: ColumnTable, column: Column) -> None:
    values = table.columns[column.name]
    row = column.first_wrong(values)
    if row is None:
        return
    value = values[row]
    found = "the value is missing" if np.isnan(value) else f"the value is {value:.12g}"
    raise RecordError(
        f"{table.path}, line {table.line(row)}, column {column.name}: {found}, where {column.kind} should stand."
    )
