"""Both scars from above, in true colours of depth."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize, PowerNorm
from matplotlib.figure import Figure

from wirewear.pictures.smooth import smooth_scar, worn_half_extent
from wirewear.pictures.style import (
    DEPTH_COLOURS,
    GREY,
    WIDTH_in,
    cycle_name,
    new_figure,
    panel_letters,
    round_below,
    scale_bar,
    sliding_arrow,
)
from wirewear.results import RunResult, Scar
from wirewear.results.scar import called

#: Pixels along the longer side of a map.
RESOLUTION = 420

#: Least distance of ticks on a root-of-depth colour bar, as a share of its length.
LEAST_TICK_DISTANCE = 0.1


def scars_from_above(results: Sequence[RunResult]) -> Figure:
    """Depth of both scars at each run's last logged cycle: one row for each run, one frame and colour scale for all."""
    rows = [last_scars(result) for result in results]
    figure, grid = _grid_of_maps(rows, Normalize(0.0, deepest(rows)))
    for row, scars, result in zip(grid, rows, results, strict=True):
        for axes, scar in zip(row, scars, strict=True):
            axes.set_title(f"{result.label}: {called(scar.body)}")
            note = f"{cycle_name(scar.cycle)} cycles\ndeepest {scar.max_depth_um:.1f} µm"
            axes.text(0.03, 0.96, note, transform=axes.transAxes, ha="left", va="top", fontsize=7.5)
            sliding_arrow(axes)
            scale_bar(axes, round_below(0.4 * axes.get_xlim()[1]))
    panel_letters(list(grid.flat))
    return figure


def scar_series(result: RunResult, cycles: Sequence[int]) -> Figure:
    """Depth of both scars of one run at several cycles, one row for each body; colours follow the root of the depth."""
    rows = [[result.scar(cycle, body) for cycle in cycles] for body in result.bodies]
    worst = deepest(rows)
    figure, grid = _grid_of_maps(rows, PowerNorm(0.5, 0.0, worst), root_ticks(worst))
    for axes, scar in zip(grid[0], rows[0], strict=True):
        axes.set_title(f"cycle {cycle_name(scar.cycle)}")
    for axes in grid[-1]:
        axes.set_xlabel("x, sliding [µm]")
    for axes, body in zip(grid[:, 0], result.bodies, strict=True):
        axes.set_ylabel(f"{called(body)}\ny [µm]")
    scale_bar(grid[0, 0], round_below(0.5 * grid[0, 0].get_xlim()[1]))
    figure.suptitle(result.label, x=0.01, ha="left", fontweight="bold", fontsize=9)
    return figure


def last_scars(result: RunResult) -> list[Scar]:
    """The driven and the held body's scar at the last cycle that has both.

    Raises:
        ResultError: the run has logged no scars.
    """
    last = max(result.scar_cycles(), default=1)
    return [result.scar(last, body) for body in result.bodies]


def deepest(rows: Sequence[Sequence[Scar]]) -> float:
    """Worst depth [µm] of all scars, the end of their common colour scale; 1 µm if all are unworn."""
    return max(scar.max_depth_um for row in rows for scar in row) or 1.0


def root_ticks(worst: float) -> list[float]:
    """Zero and the round depths up to the worst that are far enough apart on a colour bar of the root of the depth."""
    ticks, step = [worst], round_below(worst)
    while (step / worst) ** 0.5 > LEAST_TICK_DISTANCE:
        if (ticks[-1] / worst) ** 0.5 - (step / worst) ** 0.5 > LEAST_TICK_DISTANCE:
            ticks.append(step)
        step = round_below(0.99 * step)
    return [0.0, *reversed(ticks)]


def _grid_of_maps(
    rows: Sequence[Sequence[Scar]], norm: Normalize, ticks: Sequence[float] | None = None
) -> tuple[Figure, Any]:
    columns = len(rows[0])
    half_x, half_y = (1.25 * half for half in worn_half_extent([scar for row in rows for scar in row]))
    panel_width_in = 0.80 * WIDTH_in / columns
    figure = new_figure(len(rows) * (panel_width_in * half_y / half_x + 0.28) + 0.45)
    grid = figure.subplots(len(rows), columns, sharex=True, sharey=True, squeeze=False)
    for row, scars in zip(grid, rows, strict=True):
        for axes, scar in zip(row, scars, strict=True):
            draw_map(axes, scar, half_x, half_y, norm)
    for axes in grid[-1]:
        axes.set_xlabel("x [µm]")
    for axes in grid[:, 0]:
        axes.set_ylabel("y [µm]")
    colours = ScalarMappable(norm, DEPTH_COLOURS)
    bar = figure.colorbar(colours, ax=grid, label="worn depth [µm]", shrink=0.9, aspect=30, pad=0.015)
    if ticks is not None:
        bar.set_ticks(ticks, labels=[f"{tick:.3g}" for tick in ticks], minor=False)
    return figure, grid


def draw_map(axes: Axes, scar: Scar, half_x: float, half_y: float, norm: Normalize) -> None:
    """Depth of one scar over |x| ≤ half_x and |y| ≤ half_y [µm], with the axis of a body that has one."""
    step = 2.0 * max(half_x, half_y) / RESOLUTION
    x, y = (np.arange(-half + step / 2, half, step) for half in (half_x, half_y))
    extent = (x[0] - step / 2, x[-1] + step / 2, y[0] - step / 2, y[-1] + step / 2)
    image = smooth_scar(scar).sampled(x, y).T
    axes.imshow(image, cmap=DEPTH_COLOURS, norm=norm, origin="lower", extent=extent, interpolation="bilinear")
    axes.grid(visible=False)
    axes.spines[:].set_visible(True)
    axes.set_xlim(-half_x, half_x)
    axes.set_ylim(-half_y, half_y)
    axes.set_aspect("equal")
    if scar.diameter_mm == scar.diameter_along_mm:
        return
    angle = np.radians(scar.axis_angle_deg)
    # Dash-dotted, as engineers draw the axis of a cylinder.
    axes.axline((0.0, 0.0), (np.cos(angle), np.sin(angle)), color=GREY, linewidth=0.7, linestyle=(0, (8, 2, 1, 2)))
