"""A simulation and an experiment record side by side."""

from dataclasses import asdict, dataclass
from typing import Any

from wirewear.comparison.differences import (
    Difference,
    evolution_differences,
    loop_differences,
    scar_differences,
)
from wirewear.comparison.loops import LoopPair, loop_pairs
from wirewear.comparison.scars import ScarPair, scar_pairs
from wirewear.errors import RecordError
from wirewear.quantity import counted
from wirewear.records.checking import problems_told
from wirewear.records.values import ExperimentRecord
from wirewear.results import RunResult


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """What `compare` found: matched loops and scars, the table of differences, and what was left out."""

    result: RunResult
    record: ExperimentRecord
    loops: tuple[LoopPair, ...]
    scars: tuple[ScarPair, ...]
    differences: tuple[Difference, ...]
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        return (
            f"<Comparison of {self.result.label!r} and {self.record.name!r}: {len(self.loops)} cycles, "
            f"{len(self.scars)} scars, {len(self.differences)} differences>"
        )

    def to_json(self) -> dict[str, Any]:
        """Table, registrations and notes as plain values."""
        return {
            "format": 1,
            "result": self.result.label,
            "record": self.record.name,
            "matched_cycles": [[pair.cycle, pair.simulated_cycle] for pair in self.loops],
            "differences": [asdict(row) for row in self.differences],
            "registrations": [
                {"wire": pair.wire, "repeat": repeat, **asdict(registration)}
                for pair in self.scars
                for repeat, registration in zip(pair.repeats, pair.registrations, strict=True)
            ],
            "notes": list(self.notes),
        }


def compare(result: RunResult, record: ExperimentRecord) -> Comparison:
    """Compare a simulation with a record: loops at matching cycles, evolution, and scars after registration.

    Raises:
        RecordError: they have no cycle in common, or nothing can be concluded from the record.
    """
    told = problems_told(record)
    if result.status != "complete":
        told = (f"The run {result.label!r} is not complete ({result.message}).", *told)
    loops, loop_notes = loop_pairs(result, record)
    if not loops:
        logged = ", ".join(counted(loop.cycle) for loop in result.loops) or "none"
        raise RecordError(
            f"the result {result.label!r} and the record {record.name!r} have no analysable loop of a common cycle: "
            f"the result's cycles are {logged}, the record's {', '.join(map(counted, record.cycles))}."
        )
    scars, scar_notes = scar_pairs(result, record)
    rows = [*loop_differences(loops), *evolution_differences(result, record), *scar_differences(scars)]
    return Comparison(result, record, loops, scars, tuple(rows), (*told, *record.notes, *loop_notes, *scar_notes))
