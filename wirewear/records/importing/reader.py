"""What a reader of a laboratory's files is."""

import struct
import zipfile
import zlib
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from wirewear.base.delimited import DelimitedLayout
from wirewear.records.values import Array

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


def reason_of(problem: Exception) -> str:
    """What an exception says, on one line and not too long."""
    return " ".join(str(problem).split())[:120] or type(problem).__name__


@dataclass(frozen=True)
class Channel:
    """What a file offers as a column: its name in a mapping, and unit and samples per second where they are told."""

    name: str
    unit: str = ""
    sample_rate_Hz: float | None = None


class Reader(ABC):
    """Reads columns of numbers from files of one kind; a mapping chooses it by ``kind``."""

    #: Name in a mapping's ``kind = "..."``.
    kind: ClassVar[str]

    @abstractmethod
    def columns(self, path: Path, layout: DelimitedLayout, wanted: Mapping[str, str | int]) -> dict[str, Array]:
        """The wanted columns as they stand in the file: (n,), or (samples, cycles) where the file holds matrices.

        Args:
            path: the file.
            layout: the mapping's keys on delimited text, for readers that need them.
            wanted: the record's columns, and for each the name or the number (from 1 on) of the file's.

        Raises:
            RecordError: the file cannot be read, lacks a column or holds text for a number; one sentence.
        """

    def reads(self, head: bytes) -> bool:  # noqa: ARG002
        """Whether a file that begins with these 512 bytes is of this kind; False where only a mapping can tell."""
        return False

    def channels(self, path: Path) -> tuple[Channel, ...]:  # noqa: ARG002
        """What a file offers as columns; nothing where the kind does not name them.

        Raises:
            RecordError: the file cannot be read; one sentence.
        """
        return ()
