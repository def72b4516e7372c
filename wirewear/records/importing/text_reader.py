"""Base class of readers of laboratories' files, and the reader of delimited text.

A mapping's value is open if it is still "?", to be filled in by the user.
"""

import re
import struct
import zipfile
import zlib
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from geometry.arrays import Array
from wirewear.base.delimited import DelimitedLayout, DelimitedText, read_delimited
from wirewear.base.errors import RecordError
from wirewear.base.files import read_text
from wirewear.base.recognising import Held, require_no_other
from wirewear.base.words import nearest, shown
from wirewear.test.bodies import OPEN

_OPEN_LINE = re.compile(r"^\s*(\w+) *=[^#\n]*[\"']\?[\"']")

_GROUP = re.compile(r"(\d+):(\d+)")  #: Columns side by side that are one channel, such as ``2:129``.

#: Found by reading files with bytes changed, cut off and left out: readers trust sizes, names and types in the file.
DAMAGED_FILE_ERRORS: tuple[type[Exception], ...] = (
    OSError,
    EOFError,
    ValueError,
    TypeError,
    LookupError,
    ArithmeticError,
    AttributeError,
    NameError,
    AssertionError,
    RuntimeError,
    MemoryError,
    struct.error,
    zipfile.BadZipFile,
    zlib.error,
)


def open_lines(text: str) -> list[tuple[int, str]]:
    """Number, counted from 1, and key of each line of a mapping that is open."""
    found = ((number, _OPEN_LINE.match(line)) for number, line in enumerate(text.splitlines(), start=1))
    return [(number, match[1]) for number, match in found if match]


def lines_to_fill_in(text: str) -> str:
    """Text naming the open lines of a mapping: "line 6 (diameter_mm) and line 14 (displacement_um)"; "" if there are
    none.
    """
    *most, last = [f"line {number} ({key})" for number, key in open_lines(text)] or [""]
    return f"{', '.join(most)} and {last}" if most else last


def require_mapping(path: Path) -> None:
    """Raise RecordError, in one sentence, if a file is of another kind, such as a study or a record, or still has
    lines to be filled in.
    """
    require_no_other(path, RecordError, Held.MAPPING)
    if path.is_file() and (left := lines_to_fill_in(read_text(path, RecordError))):
        raise RecordError(f'{path} is not filled in: put what is right in place of "{OPEN}" in {left}.')


def reason_of(problem: Exception) -> str:
    """Message of an exception in one line of at most 120 characters."""
    return " ".join(str(problem).split())[:120] or type(problem).__name__


@dataclass(frozen=True)
class Channel:
    """Column that a file offers: its name for a mapping, and its unit ("" if unstated) and samples per second (None if
    unstated).
    """

    name: str
    unit: str = ""
    sample_rate_Hz: float | None = None


class Reader(ABC):
    """Base class of readers of columns from one kind of file, chosen in a mapping by `kind`."""

    #: Name in a mapping's ``kind = "..."``.
    kind: ClassVar[str]

    @abstractmethod
    def columns(self, path: Path, layout: DelimitedLayout, wanted: Mapping[str, str | int]) -> dict[str, Array]:
        """Wanted columns by the record's names as they stand in the file: (n,), or matrices of cycles by samples either
        way round.

        layout: layout of delimited text by the mapping, for readers that need it. wanted: name or number (from 1) of
        the file's column, by the record's column. Raises RecordError, in one sentence, if the file cannot be read,
        lacks a column or holds text for a number.
        """

    def reads(self, head: bytes) -> bool:  # noqa: ARG002
        """True if a file that begins with these 512 bytes is of this kind; False if only a mapping can tell."""
        return False

    def channels(self, path: Path) -> tuple[Channel, ...]:  # noqa: ARG002
        """Columns that a file offers; empty if this kind of file does not name them.

        Raises RecordError, in one sentence, if the file cannot be read.
        """
        return ()


class TextReader(Reader):
    """Reader of delimited text; the column "2:129" is a group of columns with one cycle in each row or column."""

    kind = "text"

    def columns(self, path: Path, layout: DelimitedLayout, wanted: Mapping[str, str | int]) -> dict[str, Array]:
        """Wanted columns of the text (n,); rows that end early give NaN, times of day become seconds. A group of
        columns such as "1:128" gives a matrix (columns, n).
        """
        text = read_delimited(path, layout)
        start = text.layout.lines_before_rows
        if next(text.rows(), None) is None:
            raise RecordError(f"{path}, line {start + 1}: there are no numbers below the header.")
        groups = {name: _group(text, column) for name, column in wanted.items()}
        alone = {name: _place(text, column) for name, column in wanted.items() if groups[name] is None}
        parts = {f"{name} {place}": place for name, group in groups.items() for place in group or ()}
        read = text.numbers(alone | parts, as_logged=True, clock="time_s").columns
        return {
            name: read[name] if group is None else np.stack([read[f"{name} {place}"] for place in group])
            for name, group in groups.items()
        }


def _group(text: DelimitedText, column: str | int) -> range | None:
    """Indices of a group of columns; None for a single column."""
    found = _GROUP.fullmatch(str(column)) if column not in text.names else None
    if found is None:
        return None
    first, last = int(found[1]), int(found[2])
    if not 1 <= first < last:
        raise RecordError(
            f"{text.path}: {column!r} is no group of columns: their numbers go up from 1, such as '1:128'."
        )
    return range(first - 1, last)


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
