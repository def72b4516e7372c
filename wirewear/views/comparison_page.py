"""The comparison as one HTML page that needs no other file: what differs first, then loops, evolution and scars."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from wirewear.base import frame
from wirewear.base.quantity import counted
from wirewear.views.differences import EVOLUTION_FIGURES, Difference, common_evolution, worst_differences

if TYPE_CHECKING:
    from wirewear.records.values import Array
    from wirewear.views.comparison import RecordComparison
    from wirewear.views.matched_loops import LoopPair
    from wirewear.views.registration import ScarPair

HERE = Path(__file__).parent

#: A difference of more than this many scatters is no chance.
BEYOND = 3.0

#: Friction measures of a loop, by the attribute of its figures.
FRICTION = {
    "friction_max": "largest Q/P",
    "friction_energy": "from energy",
    "friction_geometry_independent": "geometry-independent",
}

#: Digits of a number in the page, and of the points of a loop that are shown.
DIGITS, EVERY_PHASE = 5, 2


def page(comparison: RecordComparison, maps: bytes | None) -> str:
    """The page; `maps` is an SVG picture of the registered scars."""
    worst = worst_differences(comparison.differences)
    return frame.rendered(
        HERE / "comparison_page.html",
        {
            "report": comparison.to_json(),
            "sentences": [
                *([comparison.unlike] if comparison.unlike else []),
                sentence(worst),
                *_scatter_known(comparison.differences),
            ],
            "alike": not comparison.unlike and not any(_beyond(row) for row in worst),
            "worst": worst,
            "evolution": EVOLUTION_FIGURES,
            "scars": bool(comparison.scars),
            "maps": None if maps is None else frame.inline_svg(maps, "maps"),
            "data": frame.embedded(page_data(comparison)),
            "script": frame.script(frame.HERE / "charts.js", HERE / "comparison_page.js"),
            "beyond": BEYOND,
        },
        {"hundredths": _hundredths},
    )


def sentence(worst: Sequence[Difference]) -> str:
    """What a reader in a hurry needs to know."""
    judged = [row for row in worst if row.in_scatter is not None]
    beyond = [row for row in judged if _beyond(row)]
    if not judged:
        return "How far tests scatter is not known from this record, so that no difference can be judged."
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


def page_data(comparison: RecordComparison) -> dict[str, Any]:
    """Loops, evolution and sections as plain values."""
    return {
        "loops": [_loop(pair) for pair in comparison.loops],
        "evolution": {
            name: {
                "label": f"{quantity} [{unit}]",
                "simulated": [_numbers(comparison.result.evolution[key]) for key in ("cycle", name)],
                "measured": _measured(comparison, name),
            }
            for quantity, unit, name in EVOLUTION_FIGURES
        },
        "friction": {name: {"label": label} | _friction(comparison.loops, name) for name, label in FRICTION.items()},
        "scars": [_sections(pair) for pair in comparison.scars],
    }


def _loop(pair: LoopPair) -> dict[str, Any]:
    return {
        "cycle": pair.cycle,
        "simulated": [_numbers(values[::EVERY_PHASE]) for values in pair.simulated],
        "measured": [[_numbers(values[::EVERY_PHASE]) for values in test] for test in pair.measured],
    }


def _measured(comparison: RecordComparison, name: str) -> list[list[list[float | None]]]:
    """Cycles and values of each repeat: the record's evolution, or the figures of its loops where it has none."""
    cycles, tests = common_evolution(comparison.record, name)
    if cycles.size:
        return [[_numbers(cycles), _numbers(test)] for test in tests]
    repeats = sorted({repeat for pair in comparison.loops for repeat in pair.repeats})
    return [
        [_numbers(at), _numbers(values)]
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


def _friction(pairs: Sequence[LoopPair], name: str) -> dict[str, Any]:
    simulated = [(pair.cycle, getattr(pair.simulated_figures, name)) for pair in pairs]
    known = [(cycle, figure.value) for cycle, figure in simulated if figure is not None]
    repeats = sorted({repeat for pair in pairs for repeat in pair.repeats})
    return {
        "simulated": [_numbers([row[column] for row in known]) for column in (0, 1)],
        "measured": [[_numbers(values) for values in _of_loops(pairs, repeat, name)] for repeat in repeats],
    }


def _sections(pair: ScarPair) -> dict[str, Any]:
    cuts = [("along", "x", pair.x_um, pair.section_along), ("across", "y", pair.y_um, pair.section_across)]
    return {
        "wire": pair.wire,
        "cycle": pair.simulated_cycle,
        "sections": [
            {
                "title": f"{pair.name}, {way} the motion",
                "label": f"{axis}, {way} the motion [µm]",
                "at": _numbers(at),
                "simulated": _numbers(cut(pair.simulated)),
                "measured": [_numbers(cut(depth)) for depth in pair.measured],
            }
            for way, axis, at, cut in cuts[: 2 if pair.is_map else 1]
        ],
    }


def _scatter_known(rows: Sequence[Difference]) -> list[str]:
    if any(row.basis == "one loop's uncertainty" for row in rows):
        return ["There is one repeat only: what counts as a scatter is the uncertainty of one loop's analysis."]
    return []


def _beyond(row: Difference) -> bool:
    return row.in_scatter is not None and abs(row.in_scatter) > BEYOND


def _numbers(values: Sequence[float] | Array) -> list[float | None]:
    return [float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None for value in values]


def _hundredths(value: float) -> str:
    """A figure with two decimals, without the minus of a rounded zero."""
    return f"{round(value, 2) + 0.0:.2f}".replace("-", "−")
