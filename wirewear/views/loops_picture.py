"""Loops with the fits drawn in: both micro-slip branches, their fitted halves, δa, δ0 and the friction measures."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from geometry.arrays import Array
from wirewear.base.writing import prepared_folder
from wirewear.loops import LoopFigures
from wirewear.pictures.smooth import chosen_cycles
from wirewear.pictures.style import GREY, INK, VARIANT_COLOURS, cycle_name, new_figure, panel_letters, save
from wirewear.views.loops_report import AnalysedLoop, rounded

LOOP, FIT, WIDTH = INK, VARIANT_COLOURS[1], VARIANT_COLOURS[0]


def draw_loops(analysed: Sequence[AnalysedLoop], path: Path) -> Path:
    """Draw the first repeat's loops, at most six cycles, as PNG; the folder is made if need be."""
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
        axes.set(
            title=f"cycle {cycle_name(item.loop.cycle)}, {item.figures.regime}",
            xlabel="displacement δ [µm]",
            ylabel="tangential force Q [N]",
        )
    _limit(panels[0], [_kept(item, item.figures) for item in chosen if item.figures is not None])
    if len(chosen) > 1:
        panel_letters(panels[: len(chosen)])
    named = {label: handle for axes in panels for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(named.values(), named.keys(), loc="outside lower center", ncols=4)
    return figure


def _kept(item: AnalysedLoop, figures: LoopFigures) -> tuple[Array, Array]:
    """Displacement and force without outliers."""
    keep = np.setdiff1d(np.arange(len(item.loop.displacement_um)), figures.outlier_samples)
    return item.loop.displacement_um[keep], item.loop.tangential_force_N[keep]


def _limit(axes: Axes, kept: Sequence[tuple[Array, Array]]) -> None:
    """Limits that hold all loops and, below, the arrow of the stroke: far outliers would shrink loops to nothing."""
    x, q = (np.concatenate(values) for values in zip(*kept, strict=True))
    for values, below, limit in ((x, 0.06, axes.set_xlim), (q, 0.26, axes.set_ylim)):
        extent = float(np.ptp(values))
        limit(float(values.min()) - below * extent, float(values.max()) + 0.06 * extent)


def _panel(axes: Axes, item: AnalysedLoop, figures: LoopFigures) -> None:
    x, q = _kept(item, figures)
    axes.plot(np.append(x, x[0]), np.append(q, q[0]), color=LOOP, linewidth=1.0, label="samples")
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
    for half, height, text in ((slip, level, "\n".join([below[0], *elastic])), (stroke, bottom, below[1])):
        arrow = {"arrowstyle": "<|-|>", "color": WIDTH, "linewidth": 1.0, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", (middle - half, height), (middle + half, height), arrowprops=arrow)
        _text(axes, text, (middle, height), -3)
    _text(axes, "\n".join(friction), (middle, level), 3)


def _text(axes: Axes, text: str, place: tuple[float, float], points: int) -> None:
    side = "bottom" if points > 0 else "top"
    offset = {"xytext": (0, points), "textcoords": "offset points", "ha": "center", "va": side}
    axes.annotate(text, place, color=WIDTH, fontsize=7, linespacing=1.25, **offset)  # type: ignore[arg-type]


def _texts(figures: LoopFigures) -> tuple[list[str], list[str]]:
    """Measures of friction, and stiffness with energy, each in lines."""
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
    return [f"{name} = {' ± '.join(rounded(value))}" for name, value in friction if value is not None], elastic
