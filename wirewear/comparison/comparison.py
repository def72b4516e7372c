"""Comparison of a simulation with an experiment record: matched loops and scars, and a table of differences."""

from dataclasses import asdict, dataclass

from wirewear.base.errors import RecordError
from wirewear.base.words import counted
from wirewear.comparison.differences import (
    Difference,
    LoopPair,
    evolution_differences,
    loop_differences,
    loop_pairs,
    scar_differences,
)
from wirewear.comparison.registration import ScarPair, scar_pairs
from wirewear.records import AnyRecord
from wirewear.records.checking import problems_of
from wirewear.records.remarks import unlike_conditions
from wirewear.records.tables import curved, each_wire
from wirewear.results import RunResult

BEYOND = 3.0  #: A difference of more than this many scatters is no chance.


@dataclass(frozen=True, eq=False, repr=False)
class RecordComparison:
    """Result of `compare`: matched loops and scars, and the table of differences.

    notes: sentences on what was left out. unlike: sentence on the conditions in which run and record differ; None if
    they are of the same test.
    """

    result: RunResult
    record: AnyRecord
    loops: tuple[LoopPair, ...]
    scars: tuple[ScarPair, ...]
    differences: tuple[Difference, ...]
    notes: tuple[str, ...]
    unlike: str | None = None

    def __repr__(self) -> str:
        return (
            f"<RecordComparison of {self.result.label!r} and {self.record.name!r}: {len(self.loops)} cycles, "
            f"{len(self.scars)} scars, {len(self.differences)} differences>"
        )

    def to_json(self) -> dict[str, object]:
        """Table of differences, registrations and notes as plain values for JSON."""
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
            "unlike_conditions": self.unlike,
            "notes": list(self.notes),
        }


def compare(result: RunResult, record: AnyRecord) -> RecordComparison:
    """Compare a simulation with a record: loops at matching cycles, evolution, and scars after registration; a line
    contact over its whole length. Raises RecordError if there is no common cycle with a loop (nor, for records that may
    lack loops, a common scar), or if a problem of the record forbids conclusions.
    """
    problems = problems_of(record)
    if result.status != "complete":
        problems = (f"The run {result.label!r} is not complete ({result.message}).", *problems)
    result = result.of_extent(record.tables.extent)
    loops, loop_notes = loop_pairs(result, record)
    scars, scar_notes = scar_pairs(result, record)
    if not loops and (record.tables.needs_loops or not scars):
        logged = ", ".join(counted(loop.cycle) for loop in result.loops) or "none"
        raise RecordError(
            f"the result {result.label!r} and the record {record.name!r} have no analysable loop of a common cycle: "
            f"the result's cycles are {logged}, the record's {', '.join(map(counted, record.cycles)) or 'none'}."
        )
    rows = [*loop_differences(loops), *evolution_differences(result, record), *scar_differences(scars)]
    notes = (*problems, *record.notes, *loop_notes, *scar_notes)
    own = {key: value for name in ("conditions", "pad", "wires") for key, value in result.study.get(name, {}).items()}
    own |= curved(result.study.get("bodies") or each_wire(result.study.get("wires", {})))
    asked = record.tables.conditions.cycles
    pairs = {key: (own.get(key), value) for key, value in record.tables.of_study.items()}
    return RecordComparison(
        result,
        record,
        loops,
        scars,
        tuple(rows),
        notes,
        unlike_conditions(pairs, (float(own.get("cycles", asked)), float(asked))),
    )
