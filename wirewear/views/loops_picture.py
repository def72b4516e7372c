"""Picture of loops, with the fitted lines and the samples that gave each figure."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from geometry.arrays import Array
from wirewear.base.writing import prepared_folder
from wirewear.loops import LoopFigures
from wirewear.pictures.panels import draw_loop, name_axes
from wirewear.pictures.smooth import chosen_cycles
from wirewear.pictures.style import GREY, INK, VARIANT_COLOURS, cycle_name, new_figure, panel_letters, save
from wirewear.views.loops_report import AnalysedLoop, rounded, with_interval

LOOP, FIT, WIDTH = INK, VARIANT_COLOURS[1], VARIANT_COLOURS[0]

#: How samples that gave a figure are marked, beside those of the stiffness.
MARKS: Mapping[str, Mapping[str, Any]] = {
    "friction": {"marker": "o", "color": VARIANT_COLOURS[2], "alpha": 0.35},
    "slip": {"marker": "D", "color": WIDTH, "markerfacecolor": "none"},
}


def draw_loops(analysed: Sequence[AnalysedLoop], path: Path) -> Path:
    """Draw up to six loops of the first repeat to a picture file, creating its folder if missing, and return its
    path.
    """
    shown = [item for item in analysed if item.figures is not None]
    shown = [item for item in shown if item.loop.repeat == shown[0].loop.repeat]
    cycles = chosen_cycles([item.loop.cycle for item in shown])
    chosen = [item for item in shown if item.loop.cycle in cycles]
    prepared_folder(path.parent)
    return save(lambda: figure_of(chosen), path)


def figure_of(chosen: Sequence[AnalysedLoop]) -> Figure:
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
    kept = [_kept(item, item.figures) for item in chosen if item.figures is not None]
    x, q = (np.concatenate(values) for values in zip(*kept, strict=True))
    # The limits hold all loops, and below them the arrow of the stroke.
    for values, below, limit in ((x, 0.06, panels[0].set_xlim), (q, 0.26, panels[0].set_ylim)):
        extent = float(np.ptp(values))
        limit(float(values.min()) - below * extent, float(values.max()) + 0.06 * extent)
    if len(chosen) > 1:
        panel_letters(panels[: len(chosen)])
    named = {label: handle for axes in panels for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(named.values(), named.keys(), loc="outside lower center", ncols=3)
    return figure


def _kept(item: AnalysedLoop, figures: LoopFigures) -> tuple[Array, Array]:
    keep = np.setdiff1d(np.arange(len(item.loop.displacement_um)), figures.outlier_samples)
    return item.loop.displacement_um[keep], item.loop.tangential_force_N[keep]


def _panel(axes: Axes, item: AnalysedLoop, figures: LoopFigures) -> None:
    x, q = _kept(item, figures)
    draw_loop(axes, x, q, color=LOOP, linewidth=1.0, label="samples (area: energy)")
    if figures.outlier_samples:
        bad = list(figures.outlier_samples)
        outliers = item.loop.displacement_um[bad], item.loop.tangential_force_N[bad]
        axes.plot(*outliers, "x", color=GREY, markersize=4, label="left out")
    for name, marks in MARKS.items():
        if samples := list(figures.used.get(name, ())):
            own = item.loop.displacement_um[samples], item.loop.tangential_force_N[samples]
            axes.plot(*own, linestyle="", markersize=4, zorder=1.5, label=f"gave {name}", **marks)
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
            label="gave stiffness" if not place else None,
        )
        reach = np.linspace(start, start + branch.direction * branch.micro_slip_travel_um, 200)
        line = branch.intercept_N + branch.stiffness_N_per_um.value * reach
        # Behind free play the line runs on past the forces of the loop, where it says nothing.
        reach = np.where(np.abs(line) <= np.max(np.abs(item.loop.tangential_force_N[samples])), reach, np.nan)
        label = "its line, over the micro-slip" if not place else None
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
        words.append(f"µ partial slip: {with_interval(figures.friction_partial_slip)}")
    return words, elastic
