"""Intervals of results from the scatter of inputs: a table for the terminal, CSV, and a page with bands of the
loops.
"""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure
from rich import box
from rich.table import Table

from wirewear.base import frame
from wirewear.base.errors import ResultError
from wirewear.base.units import unit_of, words_of
from wirewear.base.writing import write_csv, write_text, writing
from wirewear.pictures.panels import draw_loop, draw_loop_band, name_axes
from wirewear.pictures.style import VARIANT_COLOURS, cycle_name, new_figure, svg
from wirewear.sweeps.sweep import FIRST
from wirewear.sweeps.uncertainty import Interval, LoopBand, Uncertainty
from wirewear.views.sweep_page import SLIP, depth_among, label_of

HERE = Path(__file__).parent
TABLE, PAGE = "uncertain.csv", "uncertain.html"


def write_uncertainty(folder: Path, found: Uncertainty) -> list[Path]:
    """Write uncertain.csv and uncertain.html and return their paths. Raises ResultError if a file cannot be written."""
    rows = [vars(one) | {"unit": unit_of(one.figure)} for one in found.intervals]
    with writing(ResultError, f"cannot write the intervals to {folder}"):
        return [write_csv(folder / TABLE, rows), write_text(folder / PAGE, page(found))]


def sentence(found: Uncertainty) -> str:
    """Summary: the scattering inputs with their standard deviations, the 95 % intervals of slip and depth, and failed
    runs.
    """
    inputs = ", ".join(f"{one.key} ± {frame.figure(one.deviation)}" for one in found.inputs)
    wanted = (SLIP, depth_among(one.figure for one in found.intervals))
    shown = [one for one in found.intervals if one.figure in wanted]
    said = "; ".join(
        f"{words_of(one.figure)} {frame.figure(one.low)} to {frame.figure(one.high)} {unit_of(one.figure)}"
        for one in shown
    )
    lost = f" {found.failed} of {found.runs} runs failed." if found.failed else ""
    return f"With {inputs} (standard deviations), 95 % of tests have: {said}.{lost}"


def name_of(interval: Interval) -> str:
    """Words and unit for the result that an interval is of, with a remark if it is of the first cycle."""
    if interval.figure.startswith(FIRST):
        return f"{label_of(interval.figure.removeprefix(FIRST))}, first cycle"
    return label_of(interval.figure)


def table(found: Uncertainty) -> Table:
    """Table of the results' nominal values, medians and 95 % intervals, to be printed with rich."""
    made = Table("figure", box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("nominal", "2.5 %", "median", "97.5 %", "surrogate's error"):
        made.add_column(heading, justify="right", no_wrap=True)
    for one in found.intervals:
        numbers = (one.nominal, one.low, one.median, one.high)
        made.add_row(
            name_of(one).replace("[", r"\["), *(frame.figure(x, 4) for x in numbers), frame.figure(one.error, 2)
        )
    return made


def page(found: Uncertainty) -> str:
    """Self-contained HTML page of the intervals."""
    return frame.rendered(
        HERE / "uncertainty.html",
        {
            "found": found,
            "sentence": sentence(found),
            "bands": frame.inline_svg(svg(lambda: draw_bands(found.loops)), "bands") if found.loops else "",
        },
        {"named": name_of},
    )


def draw_bands(loops: tuple[LoopBand, ...]) -> Figure:
    """Figure with the nominal loop of each cycle and the band in which 95 % of tests lie; needs at least one loop."""
    figure = new_figure(3.2)
    panels = figure.subplots(1, len(loops), squeeze=False, sharey=True)[0]
    for axes, loop in zip(panels, loops, strict=True):
        draw_loop_band(axes, loop.displacement_um, loop.low_N, loop.high_N, color=VARIANT_COLOURS[0], alpha=0.25)
        draw_loop(axes, loop.displacement_um, loop.nominal_N, color=VARIANT_COLOURS[0], linewidth=1.4)
        name_axes(axes)
        axes.label_outer()
        axes.set_title(f"cycle {cycle_name(loop.cycle)}")
    return figure
