"""Figures of loops, the numbers that `analyse_loop` gives, as tables, as JSON, and as a picture with the fitted
lines.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from rich import box
from rich.table import Table
from rich.text import Text

from geometry.arrays import Array
from wirewear.base.words import counted
from wirewear.base.writing import prepared_folder
from wirewear.loops import LoopError, LoopFigures, Measured, StickSlip, analyse_loop
from wirewear.loops.figures import regime_of
from wirewear.pictures.panels import draw_loop, name_axes
from wirewear.pictures.smooth import chosen_cycles
from wirewear.pictures.style import GREY, INK, VARIANT_COLOURS, cycle_name, new_figure, panel_letters, save
from wirewear.records.importing.loop_sources import SampledLoop
from wirewear.records.loop_checks import DRY, NO_FRICTION

#: Figures in the order of the table and of JSON: name in `LoopFigures`, heading, factor to the heading's unit.
FIGURES = (
    ("displacement_amplitude_um", "δa [µm]", 1.0),
    ("slip_amplitude_um", "δ0 [µm]", 1.0),
    ("measured_stiffness_N_per_um", "K_t,m [N/mm]", 1e3),
    ("friction_max", "µ max", 1.0),
    ("friction_energy", "µ energy", 1.0),
    ("friction_geometry_independent", "µ geom.-indep.", 1.0),
    ("dissipated_energy_mJ", "E_d [mJ]", 1.0),
    ("energy_ratio", "A", 1.0),
    ("system_free_ratio", "B", 1.0),
    ("plateau_slope_N_per_um", "plateau slope [N/mm]", 1e3),
    ("end_hook_ratio", "end hooks", 1.0),
    ("corner_curvature", "corner curv.", 1.0),
    ("mean_force_N", "mean force [N]", 1.0),
    ("asymmetry", "asymmetry", 1.0),
)
#: What only some loops show, in a table of their own.
SHOWN_BY_SOME = (
    ("free_play_um", "free play [µm]", 1.0),
    ("force_zero_N", "force zero [N]", 1.0),
    ("friction_forward", "µ forward", 1.0),
    ("friction_backward", "µ backward", 1.0),
    ("static_overshoot", "static peak", 1.0),
)

#: What loops without a plateau leave.
WITHOUT_PLATEAU = (("friction_partial_slip", "µ partial slip", 1.0), ("used_share", "Q*/µP", 1.0))

LOOP, FIT, WIDTH = INK, VARIANT_COLOURS[1], VARIANT_COLOURS[0]


@dataclass(frozen=True, eq=False)
class AnalysedLoop:
    """A loop with its figures; if it cannot be analysed, figures are None and `refusal` is the reason."""

    loop: SampledLoop
    figures: LoopFigures | None
    refusal: str | None = None


def analyse_loops(loops: Iterable[SampledLoop]) -> tuple[AnalysedLoop, ...]:
    """Analyse loops; those that cannot be analysed keep the reason. Raises LoopError if there are none, or none of them
    can be analysed.
    """
    analysed = [_analysed(loop) for loop in loops]
    if analysed and all(item.figures is None for item in analysed):
        first = analysed[0]
        raise LoopError(
            f"no loop can be analysed; repeat {first.loop.repeat}, cycle {first.loop.cycle}: {first.refusal}"
        )
    if not analysed:
        raise LoopError("there are no loops to analyse")
    return tuple(analysed)


def _analysed(loop: SampledLoop) -> AnalysedLoop:
    try:
        signals = loop.displacement_um, loop.tangential_force_N, loop.normal_load_N
        figures = analyse_loop(*signals, time_s=loop.time_s, cycle=loop.cycle if loop.numbered else None)
    except LoopError as refusal:
        return AnalysedLoop(loop, None, str(refusal))
    ratio = figures.friction_max
    if ratio is not None and not DRY[0] <= ratio.value <= DRY[1]:
        warning = f"{NO_FRICTION.format(ratio.value)}: check the units of both"
        loop = replace(loop, notes=(*loop.notes, warning[:1].lower() + warning[1:]))
    return AnalysedLoop(loop, figures)


def loops_json(source: str, analysed: Sequence[AnalysedLoop]) -> dict[str, object]:
    """Plain values for JSON: {"source", "regime", "loops": [{"repeat", "cycle", figures by name, "notes", …}]}. source:
    name of the data. A figure is {"value", "interval95"} or None; a loop that cannot be analysed has "refused".
    """
    regime = regime_of(item.figures for item in analysed if item.figures is not None)
    return {"source": source, "regime": regime, "loops": [_json(item) for item in analysed]}


def _json(item: AnalysedLoop) -> dict[str, object]:
    found: dict[str, object] = {"repeat": item.loop.repeat, "cycle": item.loop.cycle}
    if item.figures is None:
        return found | {"refused": item.refusal}
    figures = item.figures
    for name, _, _ in (*FIGURES, *SHOWN_BY_SOME, *WITHOUT_PLATEAU):
        found[name] = _measured_json(getattr(figures, name))
    found["stick_slip"] = _stick_slip_json(figures.stick_slip)
    found["regime"] = {"value": figures.regime, "interval95": None}
    found["possible_regimes"] = list(figures.regimes)
    found["micro_slip_branches"] = [
        {
            "direction": branch.direction,
            "stiffness_N_per_um": _measured_json(branch.stiffness_N_per_um),
            "fitted_displacement_um": list(branch.displacement_um),
            "micro_slip_travel_um": branch.micro_slip_travel_um,
        }
        for branch in figures.branches
    ]
    return found | {"outlier_samples": list(figures.outlier_samples), "notes": [*item.loop.notes, *figures.notes]}


def _stick_slip_json(chatter: StickSlip | None) -> dict[str, object] | None:
    if chatter is None:
        return None
    return {
        "share": chatter.share,
        "slips_per_cycle": chatter.slips_per_cycle,
        "frequency_Hz": chatter.frequency_Hz,
        "force_drop_share": _measured_json(chatter.force_drop_share),
        "resolved": chatter.resolved,
    }


def _measured_json(measured: Measured | None) -> dict[str, object] | None:
    """Value and interval for JSON, with null for anything unknown or infinite."""
    if measured is None:
        return None
    value, low, high = (one if math.isfinite(one) else None for one in (measured.value, *measured.interval95))
    return {"value": value, "interval95": [low, high]}


def loops_table(analysed: Sequence[AnalysedLoop]) -> Table:
    """Table with one row for each loop, to be printed with rich; ± is half the 95 % interval."""

    def cells(figures: LoopFigures) -> list[str]:
        return [figures.regime.removesuffix(" slip"), *(_cell(getattr(figures, name), f) for name, _, f in FIGURES)]

    return _table(analysed, "Loops (± half the 95 % interval)", ["regime", *(head for _, head, _ in FIGURES)], cells)


def real_loops_table(analysed: Sequence[AnalysedLoop]) -> Table | None:
    """Table of free play, friction by direction, static peaks and stick-slip; None if no loop shows play, peaks or
    stick-slip.
    """

    def shows_any(figures: LoopFigures | None) -> bool:
        return figures is not None and any((figures.free_play_um, figures.static_overshoot, figures.stick_slip))

    if not any(shows_any(item.figures) for item in analysed):
        return None

    def cells(figures: LoopFigures) -> list[str]:
        numbers = [_cell(getattr(figures, name), factor) for name, _, factor in SHOWN_BY_SOME]
        return [*numbers, *_chatter_cells(figures.stick_slip)]

    chatter = ["stick-slip share", "slips a cycle", "slips [Hz]", "force drop"]
    heads = [*(head for _, head, _ in SHOWN_BY_SOME), *chatter]
    return _table(analysed, "Free play, static friction and stick-slip", heads, cells)


def partial_slip_table(analysed: Sequence[AnalysedLoop]) -> Table | None:
    """Table of friction and possible regimes from loops without a plateau; None if there are no such loops."""
    if not any(item.figures is not None and item.figures.sticking is not None for item in analysed):
        return None

    def cells(figures: LoopFigures) -> list[str]:
        numbers = [_between(getattr(figures, name)) for name, _, _ in WITHOUT_PLATEAU]
        return [*numbers, " or ".join(one.removesuffix(" slip") for one in figures.regimes)]

    heads = [*(head for _, head, _ in WITHOUT_PLATEAU), "regime may be"]
    return _table(analysed, "Without a plateau (95 % interval)", heads, cells)


def _between(measured: Measured | None) -> str:
    """Value with its interval as text, or the bounds if there is no value."""
    if measured is None:
        return "–"
    low, high = measured.interval95
    if math.isfinite(measured.value):
        return f"{measured.value:.3g} ({low:.3g} to {high:.3g})"
    return f"≥ {low:.3g}" if math.isinf(high) else f"{low:.3g} to {high:.3g}"


def _table(
    analysed: Sequence[AnalysedLoop], title: str, headings: Sequence[str], cells: Callable[[LoopFigures], list[str]]
) -> Table:
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, title=title, title_justify="left")
    repeats, cycles = ({getattr(item.loop, key) for item in analysed} for key in ("repeat", "cycle"))
    for heading, shown in (("repeat", len(repeats) > 1), ("cycle", len(cycles) > 1)):
        if shown:
            table.add_column(heading, justify="right", no_wrap=True)
    for heading in headings:
        # A unit in brackets is no markup.
        table.add_column(Text(heading), justify="right", min_width=8)
    for item in analysed:
        keys = [str(item.loop.repeat)] * (len(repeats) > 1) + [counted(item.loop.cycle)] * (len(cycles) > 1)
        own = ["refused", *["–"] * (len(headings) - 1)] if item.figures is None else cells(item.figures)
        table.add_row(*keys, *own)
    return table


def _chatter_cells(chatter: StickSlip | None) -> list[str]:
    """Texts for stick-slip: share of the sliding, slips per cycle, their frequency and the fall of the force."""
    if chatter is None:
        return ["–"] * 4
    often = "–" if chatter.frequency_Hz is None else f"{chatter.frequency_Hz:.3g}"
    least = "" if chatter.resolved else "≥ "
    return [f"{chatter.share:.0%}", f"{least}{chatter.slips_per_cycle}", often, _cell(chatter.force_drop_share, 1.0)]


def _cell(measured: Measured | None, factor: float) -> str:
    if measured is None:
        return "–"
    return "\n± ".join(rounded(measured, factor))


def rounded(measured: Measured, factor: float = 1.0) -> tuple[str, str]:
    """Texts of value × factor and of half its 95 % interval, both rounded to the first significant digit of the latter;
    four digits if the interval is no wider than round-off.
    """
    value, half = measured.value * factor, 0.5 * (measured.interval95[1] - measured.interval95[0]) * factor
    if not max(1e-5 * abs(value), 1e-9) < half < math.inf:
        return f"{round(value, 9) + 0.0:.4g}", f"{half:.1g}"
    decimals = max(-math.floor(math.log10(half)), 0)
    return f"{round(value, decimals) + 0.0:.{decimals}f}", f"{half:.{decimals}f}"


def remarks(analysed: Sequence[AnalysedLoop]) -> list[str]:
    """Notes and refusals of loops, each once, with the number of loops concerned unless that is all."""
    often: dict[str, int] = {}
    for item in analysed:
        found = item.figures.notes if item.figures else (f"refused: {item.refusal}",)
        for note in (*item.loop.notes, *found):
            often[note] = often.get(note, 0) + 1
    regimes = regimes_over_cycles(analysed)
    said = [f"{note} ({n} of {len(analysed)} loops)" if n < len(analysed) else note for note, n in often.items()]
    return said if regimes is None else [regimes, *said]


def regimes_over_cycles(analysed: Sequence[AnalysedLoop]) -> str | None:
    """Sentence on the cycles in which a mixed test slides as a whole; None for other tests."""
    known = [(item.loop.cycle, item.figures) for item in analysed if item.figures is not None]
    if regime_of(figures for _, figures in known) != "mixed":
        return None
    cycles = sorted({cycle for cycle, _ in known})
    regimes = [regime_of(figures for at, figures in known if at == cycle) for cycle in cycles]
    runs = []
    for regime, run in groupby(zip(regimes, cycles, strict=True), key=lambda one: one[0]):
        own = [cycle for _, cycle in run]
        where = f"cycle {counted(own[0])}" if len(own) == 1 else f"cycles {counted(own[0])} to {counted(own[-1])}"
        runs.append(f"{'some loops in either' if regime == 'mixed' else regime} in {where}")
    return f"a mixed test: {', '.join(runs)}"


def draw_loops(analysed: Sequence[AnalysedLoop], path: Path) -> Path:
    """Draw up to six loops of the first repeat to a picture file, creating its folder if missing, and return its
    path.
    """
    shown = [item for item in analysed if item.figures is not None]
    shown = [item for item in shown if item.loop.repeat == shown[0].loop.repeat]
    cycles = chosen_cycles([item.loop.cycle for item in shown])
    chosen = [item for item in shown if item.loop.cycle in cycles]
    prepared_folder(path.parent)
    return save(lambda: _figure(chosen), path)


def _figure(chosen: Sequence[AnalysedLoop]) -> Figure:
    columns = min(len(chosen), 2)
    rows = -(-len(chosen) // columns)
    figure = new_figure(3.4 * rows if columns > 1 else 4.6)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    panels = list(grid.flat)
    for unused in panels[len(chosen) :]:
        unused.set_visible(False)
    for axes, item in zip(panels, chosen, strict=False):
        if item.figures is None:
            continue
        _panel(axes, item, item.figures)
        name_axes(axes)
        axes.set_title(f"cycle {cycle_name(item.loop.cycle)}, {item.figures.regime}")
    _limit(panels[0], [_kept(item, item.figures) for item in chosen if item.figures is not None])
    if len(chosen) > 1:
        panel_letters(panels[: len(chosen)])
    named = {label: handle for axes in panels for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(named.values(), named.keys(), loc="outside lower center", ncols=4)
    return figure


def _kept(item: AnalysedLoop, figures: LoopFigures) -> tuple[Array, Array]:
    keep = np.setdiff1d(np.arange(len(item.loop.displacement_um)), figures.outlier_samples)
    return item.loop.displacement_um[keep], item.loop.tangential_force_N[keep]


def _limit(axes: Axes, kept: Sequence[tuple[Array, Array]]) -> None:
    """Set axis limits that hold all loops, and below them the arrow of the stroke."""
    x, q = (np.concatenate(values) for values in zip(*kept, strict=True))
    for values, below, limit in ((x, 0.06, axes.set_xlim), (q, 0.26, axes.set_ylim)):
        extent = float(np.ptp(values))
        limit(float(values.min()) - below * extent, float(values.max()) + 0.06 * extent)


def _panel(axes: Axes, item: AnalysedLoop, figures: LoopFigures) -> None:
    x, q = _kept(item, figures)
    draw_loop(axes, x, q, color=LOOP, linewidth=1.0, label="samples")
    if figures.outlier_samples:
        bad = list(figures.outlier_samples)
        outliers = item.loop.displacement_um[bad], item.loop.tangential_force_N[bad]
        axes.plot(*outliers, "x", color=GREY, markersize=4, label="left out")
    _micro_slip(axes, item, figures)
    _widths(axes, x, q, figures)


def _micro_slip(axes: Axes, item: AnalysedLoop, figures: LoopFigures) -> None:
    if figures.measured_stiffness_N_per_um is None:
        return
    for place, branch in enumerate(figures.branches):
        start = branch.displacement_um[0]
        samples = list(branch.samples)
        axes.plot(
            item.loop.displacement_um[samples],
            item.loop.tangential_force_N[samples],
            "o",
            color=FIT,
            markersize=3,
            alpha=0.6,
            label="fitted half of the micro-slip region" if not place else None,
        )
        reach = np.linspace(start, start + branch.direction * branch.micro_slip_travel_um, 200)
        line = branch.intercept_N + branch.stiffness_N_per_um.value * reach
        # Behind free play the line runs on past the forces of the loop, where it says nothing.
        reach = np.where(np.abs(line) <= np.max(np.abs(item.loop.tangential_force_N[samples])), reach, np.nan)
        label = "its line, over the whole region" if not place else None
        # Behind the shelf of free play the same line goes on.
        play = 0.0 if figures.free_play_um is None else figures.free_play_um.value
        for shift in {0.0, branch.direction * play}:
            axes.plot(reach + shift, line, color=FIT, linestyle="--", linewidth=1.2, label=label)
            label = None


def _widths(axes: Axes, x: Array, q: Array, figures: LoopFigures) -> None:
    middle, level = 0.5 * float(x.max() + x.min()), figures.mean_force_N.value
    slip, stroke = figures.slip_amplitude_um.value, figures.displacement_amplitude_um.value
    # below the loop: from mid-stroke to its end
    bottom = float(q.min()) - 0.13 * float(np.ptp(q))
    friction, elastic = _texts(figures)
    below = f"2δ0 = 2 × {slip:.4g} µm", f"2δa = 2 × {stroke:.4g} µm"
    inside = "\n".join([below[0], *elastic])
    if figures.sticking is not None:
        # A loop that thin leaves no room within.
        words = "\n".join([*friction, inside])
        axes.text(0.03, 0.96, words, color=WIDTH, fontsize=7, linespacing=1.25, va="top", transform=axes.transAxes)
        friction, inside = [], ""
    for half, height, text in ((slip, level, inside), (stroke, bottom, below[1])):
        arrow = {"arrowstyle": "<|-|>", "color": WIDTH, "linewidth": 1.0, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", (middle - half, height), (middle + half, height), arrowprops=arrow)
        _text(axes, text, (middle, height), -3)
    _text(axes, "\n".join(friction), (middle, level), 3)


def _text(axes: Axes, text: str, place: tuple[float, float], points: int) -> None:
    side = "bottom" if points > 0 else "top"
    offset = {"xytext": (0, points), "textcoords": "offset points", "ha": "center", "va": side}
    axes.annotate(text, place, color=WIDTH, fontsize=7, linespacing=1.25, **offset)  # type: ignore[arg-type]


def _texts(figures: LoopFigures) -> tuple[list[str], list[str]]:
    """Text lines for friction measures, and for stiffness and energy."""
    friction = (
        ("µ max", figures.friction_max),
        ("µ energy", figures.friction_energy),
        ("µ geometry-independent", figures.friction_geometry_independent),
    )
    elastic = [f"E_d = {' ± '.join(rounded(figures.dissipated_energy_mJ))} mJ"]
    if figures.free_play_um is not None:
        elastic.append(f"free play = {' ± '.join(rounded(figures.free_play_um))} µm")
    if figures.measured_stiffness_N_per_um is not None:
        elastic.insert(0, f"K_t,m = {' ± '.join(rounded(figures.measured_stiffness_N_per_um, 1e3))} N/mm")
    words = [f"{name} = {' ± '.join(rounded(value))}" for name, value in friction if value is not None]
    if figures.friction_partial_slip is not None:
        words.append(f"µ partial slip: {_between(figures.friction_partial_slip)}")
    return words, elastic
