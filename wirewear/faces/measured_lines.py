"""A record of a line contact to work with: one that checks, compares, fits and diagnoses itself."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from wirewear.base.quantity import counted
from wirewear.faces.asking import Asked
from wirewear.records.line_checking import check_line_record
from wirewear.records.line_comparing import compare_line
from wirewear.records.line_files import read_line_record as read_plain
from wirewear.records.line_values import LineRecord

if TYPE_CHECKING:
    from wirewear.records import RecordReport
    from wirewear.records.line_comparing import LineComparison
    from wirewear.results import RunResult


@dataclass(frozen=True, eq=False, repr=False)
class RecordOfLines(Asked[LineRecord], LineRecord):
    """A record of a line contact with what people ask of it."""

    def check(self) -> RecordReport:
        """What is wrong with the record, and what it can and cannot support."""
        return check_line_record(self)

    def compare(self, result: RunResult) -> LineComparison:
        """The record beside a simulation.

        Raises:
            RecordError: they have nothing in common, or the result has no profile at the record's last cycle.
        """
        return compare_line(result, self)

    def _scars_told(self) -> tuple[str, int]:
        return "profiles", len(self.profiles)

    def _loops_told(self) -> str:
        return f"{len(self.loops)} at {counted(len(self.cycles))} cycles"


def read_line_record(folder: str | Path) -> RecordOfLines:
    """Read and check a record of a line contact. What can be coped with is kept and told in `notes`.

    Raises:
        RecordError: the record cannot be read, or is of crossed wires; one sentence.
    """
    return RecordOfLines.of(read_plain(Path(folder)))
