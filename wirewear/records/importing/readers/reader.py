"""What a reader of a laboratory's files is."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar

from wirewear.files.delimited import Layout
from wirewear.records.values import Array


class Reader(ABC):
    """Reads columns of numbers from files of one kind; a mapping chooses it by ``kind``."""

    #: Name in a mapping's ``kind = "..."``.
    kind: ClassVar[str]

    @abstractmethod
    def columns(self, path: Path, layout: Layout, wanted: Mapping[str, str | int]) -> dict[str, Array]:
        """The wanted columns as they stand in the file: (n,), or (samples, cycles) where the file holds matrices.

        Args:
            path: the file.
            layout: the mapping's keys on delimited text, for readers that need them.
            wanted: the record's columns, and for each the name or the number (from 1 on) of the file's.

        Raises:
            RecordError: the file cannot be read, lacks a column or holds text for a number; one sentence.
        """
