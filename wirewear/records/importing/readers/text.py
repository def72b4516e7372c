"""Delimited text: what most loggers write."""

from collections.abc import Mapping
from pathlib import Path

from wirewear.errors import RecordError
from wirewear.files.delimited import DelimitedLayout, DelimitedText, read_delimited
from wirewear.quantity import nearest, shown
from wirewear.records.importing.readers.reader import Reader
from wirewear.records.values import Array


class TextReader(Reader):
    """Delimited text in the mapping's spelling."""

    kind = "text"

    def columns(self, path: Path, layout: DelimitedLayout, wanted: Mapping[str, str | int]) -> dict[str, Array]:
        """The columns of the text; rows that end early leave NaN, times of day become seconds."""
        text = read_delimited(path, layout)
        start = text.layout.lines_before_rows
        if next(text.rows(), None) is None:
            raise RecordError(f"{path}, line {start + 1}: there are no numbers below the header.")
        places = {name: _place(text, column) for name, column in wanted.items()}
        return text.numbers(places, as_logged=True, clock="time_s").columns


def _place(text: DelimitedText, column: str | int) -> int:
    if isinstance(column, int):
        return column - 1
    names, line = text.names, text.layout.line_of_names
    if not text.layout.names_line:
        raise RecordError(f"{text.path}: with names_line = false, columns are given by number, not as {column!r}.")
    if column not in names:
        hint = f"; did you mean {like!r}?" if (like := nearest(column, names)) else "."
        raise RecordError(
            f"{text.path}, line {line}: there is no column {column!r} among {shown(', '.join(names))}{hint}"
        )
    return names.index(column)
