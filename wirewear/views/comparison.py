"""A simulation and an experiment record side by side, and the files that this leaves: a page, pictures, tables."""

from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from rich import box
from rich.table import Table
from rich.text import Text

from wirewear.base.errors import RecordError
from wirewear.base.quantity import counted
from wirewear.base.writing import json_text, write_csv, write_text, writing
from wirewear.records import AnyRecord
from wirewear.records.checking import problems_told
from wirewear.records.remarks import unlike_conditions
from wirewear.results import RunResult
from wirewear.views.differences import (
    REPEATS,
    Difference,
    evolution_differences,
    loop_differences,
    scar_differences,
    worst_differences,
)
from wirewear.views.matched_loops import LoopPair, loop_pairs
from wirewear.views.registration import ScarPair, scar_pairs

TABLE_NAME, PAGE_NAME = "differences", "comparison.html"


@dataclass(frozen=True, eq=False, repr=False)
class RecordComparison:
    """What `compare` found: matched loops and scars, the table of differences, and what was left out.

    `unlike` says in which conditions the run and the record differ, None where they are of the same test.
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


def compare(result: RunResult, record: AnyRecord) -> RecordComparison:
    """Compare a simulation with a record: loops at matching cycles, evolution, and scars after registration.

    Of a line contact both are of its whole length.

    Raises:
        RecordError: they have no cycle in common, and no scars where a record may be without loops; or nothing can be
            concluded from the record.
    """
    told = problems_told(record)
    if result.status != "complete":
        told = (f"The run {result.label!r} is not complete ({result.message}).", *told)
    if record.tables.length_mm:
        result = result.of_length(record.tables.length_mm)
    loops, loop_notes = loop_pairs(result, record)
    scars, scar_notes = scar_pairs(result, record)
    if not loops and (record.tables.needs_loops or not scars):
        logged = ", ".join(counted(loop.cycle) for loop in result.loops) or "none"
        raise RecordError(
            f"the result {result.label!r} and the record {record.name!r} have no analysable loop of a common cycle: "
            f"the result's cycles are {logged}, the record's {', '.join(map(counted, record.cycles)) or 'none'}."
        )
    rows = [*loop_differences(loops), *evolution_differences(result, record), *scar_differences(scars)]
    notes = (*told, *record.notes, *loop_notes, *scar_notes)
    return RecordComparison(result, record, loops, scars, tuple(rows), notes, _unlike(result, record))


def _unlike(result: RunResult, record: AnyRecord) -> str | None:
    own = {key: value for name in ("wires", "pad", "conditions") for key, value in result.study.get(name, {}).items()}
    asked = record.tables.conditions.cycles
    pairs = {key: (own.get(key), value) for key, value in record.tables.of_study.items()}
    return unlike_conditions(pairs, (float(own.get("cycles", asked)), float(asked)))


def differences_table(comparison: RecordComparison) -> Table:
    """The largest difference of each quantity over its cycles, to be printed with rich."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, title="Largest differences", title_justify="left")
    table.add_column("from")
    table.add_column("quantity")
    for heading in ("cycle", "difference", "in scatters"):
        table.add_column(heading, justify="right", no_wrap=True)
    worst = worst_differences(comparison.differences)
    for row in worst:
        ratio = "–" if row.in_scatter is None else f"{row.in_scatter:+.2g}"
        difference = f"{row.difference:+.3g} {row.unit}".strip()
        cycle = "" if row.cycle is None else counted(row.cycle)
        table.add_row(row.source, Text(row.quantity), cycle, difference, ratio)
    if any(row.in_scatter is None and row.basis != REPEATS for row in worst):
        table.caption = "– one repeat tells no scatter: differences of quantities with a dash cannot be judged"
    return table


def write_comparison(comparison: RecordComparison, folder: Path) -> list[Path]:
    """Write one self-contained HTML page, its pictures, and the table as CSV and JSON; return their paths.

    Raises:
        RecordError: the folder cannot be written.
    """
    from wirewear.pictures.style import save, svg
    from wirewear.views import comparison_pictures as drawn
    from wirewear.views.comparison_page import page

    loops, scars, maps = comparison.loops, comparison.scars, [pair for pair in comparison.scars if pair.is_map]
    evolution = partial(drawn.evolution_picture, comparison.result, comparison.record, loops)
    drawings = {
        **({"loops": partial(drawn.loops_picture, loops)} if loops else {}),
        **({"evolution": evolution} if loops or comparison.record.evolution else {}),
        **({"scar_maps": partial(drawn.maps_picture, maps)} if maps else {}),
        **({"scar_sections": partial(drawn.sections_picture, scars)} if scars else {}),
    }
    with writing(RecordError, f"cannot write the comparison to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        pictures = {name: save(draw, folder / f"{name}.png") for name, draw in drawings.items()}
        texts = {
            f"{TABLE_NAME}.json": json_text(comparison.to_json()),
            PAGE_NAME: page(comparison, svg(drawings["scar_maps"]) if maps else None),
        }
        for name, text in texts.items():
            write_text(folder / name, text)
        table = write_csv(folder / f"{TABLE_NAME}.csv", [asdict(row) for row in comparison.differences])
    return [folder / PAGE_NAME, table, folder / f"{TABLE_NAME}.json", *pictures.values()]
