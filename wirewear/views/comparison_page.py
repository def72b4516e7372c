"""HTML page of a comparison, its pictures, and its differences as a table for the terminal, CSV and JSON."""

from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path

import numpy as np
from rich import box
from rich.table import Table
from rich.text import Text

from geometry.arrays import Array
from wirewear.base import frame
from wirewear.base.errors import RecordError
from wirewear.base.words import counted
from wirewear.base.writing import json_text, write_csv, write_text, writing
from wirewear.comparison.comparison import BEYOND, RecordComparison
from wirewear.comparison.differences import (
    EVOLUTION_FIGURES,
    REPEATS,
    Difference,
    LoopPair,
    common_evolution,
    worst_differences,
)
from wirewear.comparison.registration import ScarPair

TABLE_NAME, PAGE_NAME = "differences", "comparison.html"

HERE = Path(__file__).parent

#: Said where no repeats show how far tests scatter.
ONE_REPEAT = (
    "With one repeat, how far tests scatter is unknown: differences are given in per cent of the measured value, and "
    "none of them can be judged. Two more repeats would show which matter."
)

#: Friction measures of a loop, by the attribute of its figures.
FRICTION = {
    "friction_max": "largest Q/P",
    "friction_energy": "from energy",
    "friction_geometry_independent": "geometry-independent",
}

EVERY_PHASE = 2  #: Of the points of a loop every second is shown.


def differences_table(comparison: RecordComparison) -> Table:
    """Table of the largest difference of each quantity over its cycles, to be printed with rich."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, title="Largest differences", title_justify="left")
    table.add_column("from")
    table.add_column("quantity")
    worst = worst_differences(comparison.differences)
    judged = any(row.basis == REPEATS for row in worst)
    for heading in ("cycle", "difference", "in scatters" if judged else "in per cent"):
        table.add_column(heading, justify="right", no_wrap=True)
    for row in worst:
        ratio = row.in_scatter if judged else row.percent
        difference = f"{row.difference:+.3g} {row.unit}".strip()
        cycle = "" if row.cycle is None else counted(row.cycle)
        table.add_row(row.source, Text(row.quantity), cycle, difference, frame.figure(ratio, 2, True))
    if not judged:
        table.caption = ONE_REPEAT
    return table


def write_comparison(comparison: RecordComparison, folder: Path) -> list[Path]:
    """Write comparison.html, its pictures, and the table of differences as CSV and JSON; return their paths. Raises
    RecordError if the folder cannot be written to.
    """
    from wirewear.pictures.style import save, svg
    from wirewear.views import comparison_pictures as drawn

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
            PAGE_NAME: page(comparison, [svg(partial(drawn.map_picture, one)) for one in drawn.every_map(maps)]),
        }
        for name, text in texts.items():
            write_text(folder / name, text)
        table = write_csv(folder / f"{TABLE_NAME}.csv", [asdict(row) for row in comparison.differences])
    return [folder / PAGE_NAME, table, folder / f"{TABLE_NAME}.json", *pictures.values()]


def page(comparison: RecordComparison, maps: Sequence[bytes]) -> str:
    """Self-contained HTML page of a comparison; maps: SVG pictures of the registered scars, as bytes."""
    worst = worst_differences(comparison.differences)
    return frame.rendered(
        HERE / "comparison_page.html",
        {
            "report": comparison.to_json(),
            "sentences": [*([comparison.unlike] if comparison.unlike else []), sentence(worst)],
            "alike": not comparison.unlike and not any(_beyond(row) for row in worst),
            "worst": worst,
            "differences": comparison.differences,
            "evolution": EVOLUTION_FIGURES,
            "scars": bool(comparison.scars),
            "maps": [frame.inline_svg(one, f"map{place}") for place, one in enumerate(maps)],
            "judged": any(row.basis == REPEATS for row in comparison.differences),
            "data": frame.embedded(page_data(comparison)),
            "script": frame.script(frame.HERE / "charts.js", HERE / "comparison_page.js"),
            "beyond": BEYOND,
        },
        {"hundredths": _hundredths},
    )


def sentence(worst: Sequence[Difference]) -> str:
    """Summary in one or two sentences; worst: the largest difference of each quantity, largest first."""
    judged = [row for row in worst if row.in_scatter is not None and row.basis == REPEATS]
    beyond = [row for row in judged if _beyond(row)]
    if not judged:
        return ONE_REPEAT
    if not beyond:
        return f"Simulation and experiment agree: none of {len(judged)} quantities differs by more than three scatters."
    first = beyond[0]
    at = "" if first.cycle is None else f" at cycle {counted(first.cycle)}"
    unit = f" {first.unit}" if first.unit else ""
    return (
        f"{len(beyond)} of {len(judged)} quantities differ by more than three scatters. The largest is in "
        f"{first.quantity} ({first.source}){at}: {frame.figure(first.difference, 3, True)}{unit}, "
        f"{frame.figure(abs(first.in_scatter or 0.0), 2)} scatters."
    )


def page_data(comparison: RecordComparison) -> dict[str, object]:
    """Loops, evolution, friction and sections of the scars as plain values for the page."""
    return {
        "loops": [_loop(pair) for pair in comparison.loops],
        "evolution": {
            name: {
                "label": f"{quantity} [{unit}]",
                "simulated": [frame.numbers(comparison.result.evolution[key]) for key in ("cycle", name)],
                "measured": _measured(comparison, name),
            }
            for quantity, unit, name in EVOLUTION_FIGURES
        },
        "friction": {name: {"label": label} | _friction(comparison.loops, name) for name, label in FRICTION.items()},
        "scars": [_sections(pair) for pair in comparison.scars],
    }


def _loop(pair: LoopPair) -> dict[str, object]:
    return {
        "cycle": pair.cycle,
        "simulated": [frame.numbers(values[::EVERY_PHASE]) for values in pair.simulated],
        "measured": [[frame.numbers(values[::EVERY_PHASE]) for values in test] for test in pair.measured],
    }


def _measured(comparison: RecordComparison, name: str) -> list[list[list[float | None]]]:
    """For each repeat its cycles and values of this column, from the record's evolution or else from its loops."""
    cycles, tests = common_evolution(comparison.record, name)
    if cycles.size:
        return [[frame.numbers(cycles), frame.numbers(test)] for test in tests]
    repeats = sorted({repeat for pair in comparison.loops for repeat in pair.repeats})
    return [
        [frame.numbers(at), frame.numbers(values)]
        for at, values in (_of_loops(comparison.loops, repeat, name) for repeat in repeats)
        if at.size
    ]


def _of_loops(pairs: Sequence[LoopPair], repeat: int, name: str) -> tuple[Array, Array]:
    found: list[tuple[float, float]] = []
    for pair in pairs:
        if repeat in pair.repeats:
            place = pair.repeats.index(repeat)
            if name == "max_tangential_force_N":
                found.append((pair.cycle, float(np.abs(pair.measured[place, 1]).max())))
            elif (figure := getattr(pair.measured_figures[place], name)) is not None:
                found.append((pair.cycle, figure.value))
    columns = np.array(found, dtype=np.float64).reshape(-1, 2)
    return columns[:, 0], columns[:, 1]


def _friction(pairs: Sequence[LoopPair], name: str) -> dict[str, object]:
    simulated = [(pair.cycle, getattr(pair.simulated_figures, name)) for pair in pairs]
    known = [(cycle, figure.value) for cycle, figure in simulated if figure is not None]
    repeats = sorted({repeat for pair in pairs for repeat in pair.repeats})
    return {
        "simulated": [frame.numbers([row[column] for row in known]) for column in (0, 1)],
        "measured": [[frame.numbers(values) for values in _of_loops(pairs, repeat, name)] for repeat in repeats],
    }


def _sections(pair: ScarPair) -> dict[str, object]:
    cuts = [("along", "x", pair.x_um, pair.section_along), ("across", "y", pair.y_um, pair.section_across)]
    return {
        "wire": pair.wire,
        "cycle": pair.simulated_cycle,
        "sections": [
            {
                "title": f"{pair.name}, {way} the motion",
                "label": f"{axis}, {way} the motion [µm]",
                "at": frame.numbers(at),
                "simulated": frame.numbers(cut(pair.simulated)),
                "measured": [frame.numbers(cut(depth)) for depth in pair.measured],
            }
            for way, axis, at, cut in cuts[: 2 if pair.is_map else 1]
        ],
    }


def _beyond(row: Difference) -> bool:
    return row.in_scatter is not None and abs(row.in_scatter) > BEYOND


def _hundredths(value: float) -> str:
    """Number with two decimals and no minus before zero."""
    return f"{round(value, 2) + 0.0:.2f}".replace("-", "−")
