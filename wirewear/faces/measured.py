"""A record to work with: one that checks, compares, fits and diagnoses itself."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from wirewear.base.quantity import counted
from wirewear.faces.asking import Asked
from wirewear.records import ExperimentRecord, RecordReport, check_record
from wirewear.records import read_record as read_plain

if TYPE_CHECKING:
    from wirewear.results import RunResult
    from wirewear.views.comparison import RecordComparison


@dataclass(frozen=True, eq=False, repr=False)
class Record(Asked[ExperimentRecord], ExperimentRecord):
    """An experiment record with what people ask of it."""

    def check(self) -> RecordReport:
        """What is wrong with the record, and what it can and cannot support."""
        return check_record(self)

    def compare(self, run: RunResult) -> RecordComparison:
        """The record beside a simulation.

        Raises:
            RecordError: they have no cycle in common, or nothing can be concluded from the record.
        """
        from wirewear.views.comparison import compare

        return compare(run, self)

    def _scars_told(self) -> tuple[str, int]:
        return "scars", len(self.scars)

    def _loops_told(self) -> str:
        cycles = ", ".join(map(counted, self.cycles[:12]))
        return f"{len(self.loops)} at the cycles {cycles}" + (" …" if len(self.cycles) > 12 else "")


def read_record(folder: str | Path) -> Record:
    """Read and check a record; each file is read once. What can be coped with is kept and told in `notes`.

    Raises:
        RecordError: the record cannot be read; one sentence with file, line and column.
    """
    return Record.of(read_plain(folder))
