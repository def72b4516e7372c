"""A simulation and an experiment record side by side."""

from dataclasses import asdict, dataclass
from typing import Any

from wirewear.base.errors import RecordError
from wirewear.base.quantity import counted
from wirewear.records.checking import problems_told
from wirewear.records.remarks import unlike_conditions
from wirewear.records.values import ExperimentRecord
from wirewear.results import RunResult
from wirewear.views.differences import (
    Difference,
    evolution_differences,
    loop_differences,
    scar_differences,
)
from wirewear.views.matched_loops import LoopPair, loop_pairs
from wirewear.views.registration import ScarPair, scar_pairs


@dataclass(frozen=True, eq=False, repr=False)
class RecordComparison:
    """What `compare` found: matched loops and scars, the table of differences, and what was left out.

    `unlike` says in which conditions the run and the record differ, None where they are of the same test.
    """

    result: RunResult
    record: ExperimentRecord
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
            "unlike_conditions": self.unlike,
            "notes": list(self.notes),
        }


def compare(result: RunResult, record: ExperimentRecord) -> RecordComparison:
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
    notes = (*told, *record.notes, *loop_notes, *scar_notes)
    return RecordComparison(result, record, loops, scars, tuple(rows), notes, _unlike(result, record))


def _unlike(result: RunResult, record: ExperimentRecord) -> str | None:
    wires, asked = record.tables.wires, record.tables.conditions
    own = {**result.study.get("wires", {}), **result.study.get("conditions", {})}
    pairs = {
        "normal_load_N": asked.normal_load_N,
        "displacement_amplitude_um": asked.displacement_amplitude_um,
        "diameter_mm": wires.diameter_mm,
        "crossing_angle_deg": wires.crossing_angle_deg,
        "motion_angle_deg": wires.motion_angle_deg,
    }
    cycles = float(own.get("cycles", asked.cycles)), float(asked.cycles)
    return unlike_conditions({key: (own.get(key), value) for key, value in pairs.items()}, cycles)
