"""Pictures of scars: depth maps, sections along the motion, maps of pressure at mid-stroke and of slip distance per
cycle.

Pressure and slip are shown on the held body, whose contact does not move. Fields are interpolated smoothly (see
`smooth`), and blank where there is neither pressure nor slip. A cycle stands for the logged one nearest to it.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize, PowerNorm
from matplotlib.figure import Figure

from geometry.arrays import Array
from wirewear.pictures import style
from wirewear.pictures.panels import RESOLUTION, draw_map, draw_scar
from wirewear.pictures.smooth import smooth_field, smooth_scar, worn_half_extent
from wirewear.results import RunResult, Scar

#: Field, label of its colour bar, colours: the rows of the picture.
_ROWS = (
    ("pressure_MPa", "pressure [MPa]", style.PRESSURE_COLOURS),
    ("slip_distance_um", "slip [µm]", style.SLIP_COLOURS),
)
LEAST_TICK_DISTANCE = 0.1  #: Least distance of ticks on a root-of-depth colour bar, as a share of its length.


def scar_sections(results: Sequence[RunResult], cycles: Sequence[int]) -> Figure:
    """Picture of unworn and worn profiles at y = 0 of all runs: one row for each cycle, one column for each body.

    All panels have the same scale; heights are exaggerated by a round factor, stated in the picture. Raises ResultError
    if a run has logged no scar near one of the cycles.
    """
    bodies = results[0].bodies
    shown = {(c, w): [smooth_scar(result.scar(c, w)) for result in results] for c in cycles for w in bodies}
    half_width = 1.3 * max(_half_extent(scar) for scars in shown.values() for scar in scars)
    x = np.linspace(-half_width, half_width, 801)
    # The flanks beside the scars are of no interest: the panels end a little below the lowest worn point.
    low = min(_lowest_worn_height(scar) for scars in shown.values() for scar in scars)
    bottom, top = 1.5 * low, -0.25 * low
    # Height over width that a panel should not exceed.
    exaggeration = style.round_below(max(0.75 * 2.0 * half_width / (top - bottom), 1.0))
    panel_height_in = 0.42 * style.WIDTH_in * exaggeration * (top - bottom) / (2.0 * half_width)
    figure = style.new_figure(len(cycles) * (panel_height_in + 0.3) + 0.7)
    grid = figure.subplots(len(cycles), len(bodies), sharex=True, sharey=True, squeeze=False)
    for row, cycle in zip(grid, cycles, strict=True):
        for axes, body in zip(row, bodies, strict=True):
            scars = shown[cycle, body]
            _draw_section(axes, results, scars, x)
            axes.set(
                title=f"{results[0].called(body)}, {style.cycle_name(scars[0].cycle)} cycles",
                aspect=exaggeration,
                xlim=(-half_width, half_width),
                ylim=(bottom, top),
            )
    for axes in grid[-1]:
        axes.set_xlabel("position along the motion x [µm]")
    for axes in grid[:, 0]:
        axes.set_ylabel("height z [µm]")
    style.panel_letters(list(grid.flat))
    handles, labels = grid[0, 0].get_legend_handles_labels()
    title = "true proportions" if exaggeration == 1.0 else f"heights × {exaggeration:g}"
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), title=title)
    return figure


def _draw_section(axes: Axes, results: Sequence[RunResult], scars: Sequence[Scar], x: Array) -> None:
    unworn, _ = profile(scars[0], x)
    axes.plot(x, unworn, color=style.GREY, linewidth=1.0, linestyle=(0, (3, 2)), label="unworn")
    for index, (result, scar) in enumerate(zip(results, scars, strict=True)):
        unworn, worn = profile(scar, x)
        look = style.variant_style(index)
        axes.fill_between(x, worn, unworn, color=look["color"], alpha=0.12, linewidth=0)
        axes.plot(x, worn, **look, label=result.label)


def profile(scar: Scar, x: Array) -> tuple[Array, Array]:
    """(unworn, worn): heights (n,) in µm of the surface at y = 0 and at x (n,) in µm, from the crown."""
    unworn = scar.unworn_height_um(*scar.wire_coordinates(x, 0.0))
    return unworn, unworn - scar.sampled(x, np.zeros(1))[:, 0]


def _lowest_worn_height(scar: Scar) -> float:
    """Lowest height in µm of the worn surface on the section, where it is worn by more than 1 % of the largest
    depth.
    """
    x, depth = scar.section_along_motion()
    worn = depth > 0.01 * scar.max_depth_um
    heights = profile(scar, x[worn] if worn.any() else x)[1]
    return min(float(heights.min()), -1.0)


def _half_extent(scar: Scar) -> float:
    """Largest |x| in µm on the section at which more than 1 % of the largest depth is worn."""
    x, depth = scar.section_along_motion()
    worn = depth > 0.01 * scar.max_depth_um
    return float(abs(x[worn]).max()) if worn.any() else float(abs(x).max())


def contact_maps(result: RunResult, cycles: Sequence[int]) -> Figure:
    """Picture of pressure and slip distance of one run, one column for each cycle; each row has one colour scale."""
    held = result.bodies[1]
    scars = [result.scar(cycle, held) for cycle in cycles]
    half_x, half_y = (1.15 * half for half in touched_half_extent(scars))
    panel_width_in = 0.80 * style.WIDTH_in / len(scars)
    figure = style.new_figure(len(_ROWS) * (panel_width_in * half_y / half_x + 0.42) + 0.5)
    grid = figure.subplots(len(_ROWS), len(scars), sharex=True, sharey=True, squeeze=False)
    for row, (field, label, colours) in zip(grid, _ROWS, strict=True):
        slip = field == "slip_distance_um"
        # By the root, as pressure falls by orders of magnitude while the scar grows.
        norm = PowerNorm(0.5, 0.0, max(float(getattr(scar, field).max()) for scar in scars) or 1.0)
        for axes, scar in zip(row, scars, strict=True):
            axial, transverse, drawn = smooth_field(scar, field, _step_um(result, scar.cycle) if slip else 0.0)
            at = scar.sliding_coordinates(axial[:, None], transverse[None, :])
            draw_map(axes, at, drawn, norm, colours, (half_x, half_y))
            note = f"max {_short(float(scar.slip_distance_um.max()))} µm" if slip else f"mean {_mean(scar):.0f} MPa"
            axes.text(0.0, 1.03, note, transform=axes.transAxes, ha="left", va="bottom", fontsize=7.5)
        row[0].set_ylabel("y [µm]")
        bar = figure.colorbar(ScalarMappable(norm, colours), ax=list(row), label=label, aspect=18, pad=0.015)
        # The largest pressure is that of a node, which does not converge: it is not written.
        ticks = root_ticks(float(norm.vmax or 1.0))[: None if slip else -1]
        bar.set_ticks(ticks, labels=[_short(tick) for tick in ticks], minor=False)
    for axes, scar in zip(grid[0], scars, strict=True):
        axes.set_title(f"cycle {style.cycle_name(scar.cycle)}", pad=16)
    for axes in grid[-1]:
        axes.set_xlabel("x, sliding [µm]")
    style.sliding_arrow(grid[1, 0])
    style.scale_bar(grid[0, 0], style.round_below(0.5 * half_x))
    shown = "pressure at mid-stroke moving towards +x, and distance slid in the cycle"
    body = f"{result.label}, {result.called(held)}" if result.label else result.called(held)
    figure.suptitle(f"{body}: {shown}", x=0.01, ha="left", fontsize=9)
    return figure


def _mean(scar: Scar) -> float:
    """Mean pressure in MPa over the area under pressure."""
    area = np.outer(np.gradient(scar.axial_um), np.gradient(scar.transverse_um)) * (scar.pressure_MPa > 0.0)
    return float((area * scar.pressure_MPa).sum() / area.sum()) if area.any() else 0.0


def touched_half_extent(scars: Sequence[Scar]) -> tuple[float, float]:
    """Largest |x| and |y| in µm, along and across the motion, where the bodies touch at mid-stroke or slide, in any of
    the scars. At least one grid spacing, where they touch at a single point.
    """
    half_x = half_y = 0.0
    for scar in scars:
        x, y = scar.sliding_coordinates(scar.axial_um[:, None], scar.transverse_um[None, :])
        touched = (scar.pressure_MPa > 0.0) | (scar.slip_distance_um > 0.0)
        if not touched.any():
            touched = np.ones_like(touched)
        half_x, half_y = (
            max(half, float(abs(place[touched]).max()), float(abs(place)[abs(place) > 0.0].min()))
            for half, place in ((half_x, x), (half_y, y))
        )
    return half_x, half_y


def _step_um(result: RunResult, cycle: int) -> float:
    """Largest displacement in µm between two samples of this cycle's loop; 0 without a loop.

    Slip distances at the contact's edge are uncertain by it, so that pictures average over this length.
    """
    motion = [loop.displacement_um for loop in result.loops if loop.cycle == cycle]
    return float(abs(np.diff(motion[0])).max(initial=0.0)) if motion else 0.0


def _short(value: float) -> str:
    return f"{value:.0f}" if value >= 100.0 else f"{value:.3g}"


def scars_from_above(results: Sequence[RunResult]) -> Figure:
    """Picture of the depth of both scars at each run's last logged cycle, one row a run, on one colour scale."""
    rows = [last_scars(result) for result in results]
    figure, grid = _grid_of_maps(rows, Normalize(0.0, deepest(rows)))
    for row, scars, result in zip(grid, rows, results, strict=True):
        for axes, scar in zip(row, scars, strict=True):
            axes.set_title(style.titled(results, result, result.called(scar.body)))
            _draw_layers(axes, result, scar)
            note = f"{style.cycle_name(scar.cycle)} cycles\ndeepest {scar.max_depth_um:.3g} µm"
            axes.text(0.03, 0.96, note, transform=axes.transAxes, ha="left", va="top", fontsize=7.5)
            style.sliding_arrow(axes)
            style.scale_bar(axes, style.round_below(0.4 * axes.get_xlim()[1]))
    style.panel_letters(list(grid.flat))
    return figure


def scar_series(result: RunResult, cycles: Sequence[int]) -> Figure:
    """Picture of the depth of both scars of one run, one column for each cycle, one row for each body; colours follow
    the root of the depth.
    """
    rows = [[result.scar(cycle, body) for cycle in cycles] for body in result.bodies]
    worst = deepest(rows)
    figure, grid = _grid_of_maps(rows, PowerNorm(0.5, 0.0, worst), root_ticks(worst))
    for axes, scar in zip(grid[0], rows[0], strict=True):
        axes.set_title(f"cycle {style.cycle_name(scar.cycle)}")
    for of_body, scars in zip(grid, rows, strict=True):
        for axes, scar in zip(of_body, scars, strict=True):
            _draw_layers(axes, result, scar)
    for axes in grid[-1]:
        axes.set_xlabel("x, sliding [µm]")
    for axes, body in zip(grid[:, 0], result.bodies, strict=True):
        axes.set_ylabel(f"{result.called(body)}\ny [µm]")
    style.scale_bar(grid[0, 0], style.round_below(0.5 * grid[0, 0].get_xlim()[1]))
    figure.suptitle(result.label, x=0.01, ha="left", fontweight="bold", fontsize=9)
    return figure


def last_scars(result: RunResult) -> list[Scar]:
    """Scars of (driven, held) body at the last logged cycle. Raises ResultError if the run has logged no scars."""
    last = max(result.scar_cycles(), default=1)
    return [result.scar(last, body) for body in result.bodies]


def deepest(rows: Sequence[Sequence[Scar]]) -> float:
    """Largest depth in µm of all scars, for their common colour scale; 1 µm if all are unworn."""
    return max(scar.max_depth_um for row in rows for scar in row) or 1.0


def root_ticks(worst: float) -> list[float]:
    """Ticks, increasing from 0 to `worst`, of a colour bar that follows the root: round values between both."""
    ticks, step = [worst], style.round_below(worst)
    while (step / worst) ** 0.5 > LEAST_TICK_DISTANCE:
        if (ticks[-1] / worst) ** 0.5 - (step / worst) ** 0.5 > LEAST_TICK_DISTANCE:
            ticks.append(step)
        step = style.round_below(0.99 * step)
    return [0.0, *reversed(ticks)]


def _grid_of_maps(
    rows: Sequence[Sequence[Scar]], norm: Normalize, ticks: Sequence[float] | None = None
) -> tuple[Figure, Any]:
    columns = len(rows[0])
    half_x, half_y = (1.25 * half for half in worn_half_extent([scar for row in rows for scar in row]))
    panel_width_in = 0.80 * style.WIDTH_in / columns
    figure = style.new_figure(len(rows) * (panel_width_in * half_y / half_x + 0.28) + 0.45)
    grid = figure.subplots(len(rows), columns, sharex=True, sharey=True, squeeze=False)
    for row, scars in zip(grid, rows, strict=True):
        for axes, scar in zip(row, scars, strict=True):
            draw_scar(axes, scar, half_x, half_y, norm)
    for axes in grid[-1]:
        axes.set_xlabel("x [µm]")
    for axes in grid[:, 0]:
        axes.set_ylabel("y [µm]")
    colours = ScalarMappable(norm, style.DEPTH_COLOURS)
    bar = figure.colorbar(colours, ax=grid, label="worn depth [µm]", shrink=0.9, aspect=30, pad=0.015)
    if ticks is not None:
        bar.set_ticks(ticks, labels=[f"{tick:.3g}" for tick in ticks], minor=False)
    return figure, grid


def _draw_layers(axes: Axes, result: RunResult, scar: Scar) -> None:
    """Draw outlines of the areas where layers are worn through on a map of depth."""
    faces = [face for face in result.layer_faces_um(scar.body) if 0.0 < face < scar.max_depth_um]
    if faces:
        x, y = (np.linspace(*ends, RESOLUTION) for ends in (axes.get_xlim(), axes.get_ylim()))
        depth = smooth_scar(scar).sampled(x, y).T
        axes.contour(x, y, depth, levels=faces, colors="black", linewidths=0.9, linestyles="dashed")
