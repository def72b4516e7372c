"""A simulation and an experiment record side by side."""

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from wirewear.comparison.differences import (
    Difference,
    evolution_differences,
    loop_differences,
    scar_differences,
)
from wirewear.comparison.loops import LoopPair, loop_pairs
from wirewear.comparison.page import page
from wirewear.comparison.pictures import evolution_picture, loops_picture
from wirewear.comparison.scar_pictures import maps_picture, sections_picture
from wirewear.comparison.scars import ScarPair, scar_pairs
from wirewear.errors import RecordError
from wirewear.files import write_text, writing
from wirewear.pictures.style import save
from wirewear.records.checking import problems_told
from wirewear.records.values import ExperimentRecord
from wirewear.results import RunResult

TABLE_NAME, PAGE_NAME = "differences", "comparison.html"


@dataclass(frozen=True, eq=False)
class Comparison:
    """What `compare` found: matched loops and scars, the table of differences, and what was left out."""

    result: RunResult
    record: ExperimentRecord
    loops: tuple[LoopPair, ...]
    scars: tuple[ScarPair, ...]
    differences: tuple[Difference, ...]
    notes: tuple[str, ...]

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
        logged = ", ".join(str(loop.cycle) for loop in result.loops) or "none"
        raise RecordError(
            f"the result {result.label!r} and the record {record.name!r} have no analysable loop of a common cycle: "
            f"the result's cycles are {logged}, the record's {', '.join(map(str, record.cycles))}."
        )
    scars, scar_notes = scar_pairs(result, record)
    rows = [*loop_differences(loops), *evolution_differences(result, record), *scar_differences(scars)]
    return Comparison(result, record, loops, scars, tuple(rows), (*told, *record.notes, *loop_notes, *scar_notes))


def write_comparison(comparison: Comparison, folder: Path) -> list[Path]:
    """Write one self-contained HTML page, its pictures, and the table as CSV and JSON; return their paths.

    Raises:
        RecordError: the folder cannot be written.
    """
    drawings: dict[str, Callable[[], Figure]] = {
        "loops": partial(loops_picture, comparison.loops),
        "evolution": partial(evolution_picture, comparison.result, comparison.record, comparison.loops),
    }
    if comparison.scars:
        drawings["scar_maps"] = partial(maps_picture, comparison.scars)
        drawings["scar_sections"] = partial(sections_picture, comparison.scars)
    with writing(RecordError, f"cannot write the comparison to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        pictures = {name: save(draw, folder / f"{name}.png") for name, draw in drawings.items()}
        texts = {
            f"{TABLE_NAME}.csv": _csv(comparison),
            f"{TABLE_NAME}.json": json.dumps(comparison.to_json(), indent=2, ensure_ascii=False),
            PAGE_NAME: page(comparison.to_json(), {name: path.read_bytes() for name, path in pictures.items()}),
        }
        for name, text in texts.items():
            write_text(folder / name, text)
    return [folder / PAGE_NAME, *(folder / name for name in texts if name != PAGE_NAME), *pictures.values()]


def _csv(comparison: Comparison) -> str:
    import csv
    import io

    lines = io.StringIO()
    names = list(Difference.__dataclass_fields__)
    writer = csv.DictWriter(lines, names, lineterminator="\n")
    writer.writeheader()
    writer.writerows({k: "" if v is None else v for k, v in asdict(row).items()} for row in comparison.differences)
    return lines.getvalue()
