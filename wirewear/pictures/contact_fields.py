"""Sections through both scars along the motion; pressure at mid-stroke and distance slid in a cycle, as maps.

The maps are of the held body, whose contact stays where it is. The fields are drawn smoothly between the grid points
(see `smooth`), and blank where nothing is pressed or slides.
"""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, Normalize, PowerNorm
from matplotlib.figure import Figure

from geometry.arrays import Array
from wirewear.pictures.scar_maps import root_ticks
from wirewear.pictures.smooth import smooth_field, smooth_scar
from wirewear.pictures.style import (
    GREY,
    PRESSURE_COLOURS,
    SLIP_COLOURS,
    WIDTH_in,
    cycle_name,
    new_figure,
    panel_letters,
    round_below,
    scale_bar,
    sliding_arrow,
    variant_style,
)
from wirewear.results import RunResult, Scar
from wirewear.results.scar import called

#: Height over width that a panel should not exceed.
TALLEST_PANEL = 0.75


def scar_sections(results: Sequence[RunResult], cycles: Sequence[int]) -> Figure:
    """Unworn and worn profile on y = 0: one row for each cycle, one column for each body, the runs overlaid.

    All panels have the same scale; the heights are exaggerated by a round factor, stated in the picture.

    Raises:
        ResultError: a run has logged no scar near one of the cycles.
    """
    bodies = results[0].bodies
    shown = {(c, w): [smooth_scar(result.scar(c, w)) for result in results] for c in cycles for w in bodies}
    half_width = 1.3 * max(_half_extent(scar) for scars in shown.values() for scar in scars)
    x = np.linspace(-half_width, half_width, 801)
    # The flanks beside the scars are of no interest: the panels end a little below the lowest worn point.
    low = min(_lowest_worn_height(scar) for scars in shown.values() for scar in scars)
    bottom, top = 1.5 * low, -0.25 * low
    exaggeration = round_below(max(TALLEST_PANEL * 2.0 * half_width / (top - bottom), 1.0))
    panel_height_in = 0.42 * WIDTH_in * exaggeration * (top - bottom) / (2.0 * half_width)
    figure = new_figure(len(cycles) * (panel_height_in + 0.3) + 0.7)
    grid = figure.subplots(len(cycles), len(bodies), sharex=True, sharey=True, squeeze=False)
    for row, cycle in zip(grid, cycles, strict=True):
        for axes, body in zip(row, bodies, strict=True):
            scars = shown[cycle, body]
            _draw_section(axes, results, scars, x)
            axes.set_title(f"{called(body)}, {cycle_name(scars[0].cycle)} cycles")
            axes.set_aspect(exaggeration)
            axes.set_xlim(-half_width, half_width)
            axes.set_ylim(bottom, top)
    for axes in grid[-1]:
        axes.set_xlabel("position along the motion x [µm]")
    for axes in grid[:, 0]:
        axes.set_ylabel("height z [µm]")
    panel_letters(list(grid.flat))
    handles, labels = grid[0, 0].get_legend_handles_labels()
    title = "true proportions" if exaggeration == 1.0 else f"heights × {exaggeration:g}"
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), title=title)
    return figure


def _draw_section(axes: Axes, results: Sequence[RunResult], scars: Sequence[Scar], x: Array) -> None:
    unworn, _ = profile(scars[0], x)
    axes.plot(x, unworn, color=GREY, linewidth=1.0, linestyle=(0, (3, 2)), label="unworn")
    for index, (result, scar) in enumerate(zip(results, scars, strict=True)):
        unworn, worn = profile(scar, x)
        style = variant_style(index)
        axes.fill_between(x, worn, unworn, color=style["color"], alpha=0.12, linewidth=0)
        axes.plot(x, worn, **style, label=result.label)


def profile(scar: Scar, x: Array) -> tuple[Array, Array]:
    """Heights [µm] of the unworn and the worn surface at (x, 0), above the crown."""
    unworn = scar.unworn_height_um(*scar.wire_coordinates(x, 0.0))
    return unworn, unworn - scar.sampled(x, np.zeros(1))[:, 0]


def _lowest_worn_height(scar: Scar) -> float:
    """Lowest height [µm] of the worn surface on the section, where a hundredth of the worst depth is worn."""
    x, depth = scar.section_along_motion()
    worn = depth > 0.01 * scar.max_depth_um
    heights = profile(scar, x[worn] if worn.any() else x)[1]
    return min(float(heights.min()), -1.0)


def _half_extent(scar: Scar) -> float:
    """Largest |x| [µm] on the section at which a hundredth of the worst depth is worn."""
    x, depth = scar.section_along_motion()
    worn = depth > 0.01 * scar.max_depth_um
    return float(abs(x[worn]).max()) if worn.any() else float(abs(x).max())


#: Field, label of its colour bar, unit of its largest value and where that is, colours: the rows of the picture.
_ROWS = (
    ("pressure_MPa", "pressure [MPa]", "MPa at a node", PRESSURE_COLOURS),
    ("slip_distance_um", "slip [µm]", "µm", SLIP_COLOURS),
)


def contact_maps(result: RunResult, cycles: Sequence[int]) -> Figure:
    """Pressure and slip of one run at several cycles, one column each; every row has one colour scale."""
    held = result.bodies[1]
    scars = [result.scar(cycle, held) for cycle in cycles]
    half_x, half_y = (1.15 * half for half in touched_half_extent(scars))
    panel_width_in = 0.80 * WIDTH_in / len(scars)
    figure = new_figure(len(_ROWS) * (panel_width_in * half_y / half_x + 0.42) + 0.5)
    grid = figure.subplots(len(_ROWS), len(scars), sharex=True, sharey=True, squeeze=False)
    for row, (field, label, unit, colours) in zip(grid, _ROWS, strict=True):
        # By the root, as pressure falls by orders of magnitude while the scar grows.
        norm = PowerNorm(0.5, 0.0, max(float(getattr(scar, field).max()) for scar in scars) or 1.0)
        for axes, scar in zip(row, scars, strict=True):
            _draw(
                axes, scar, field, norm, colours, _step_um(result, scar.cycle) if field == "slip_distance_um" else 0.0
            )
            note = f"max {_short(float(getattr(scar, field).max()))} {unit}"
            axes.text(0.0, 1.03, note, transform=axes.transAxes, ha="left", va="bottom", fontsize=7.5)
            axes.set_xlim(-half_x, half_x)
            axes.set_ylim(-half_y, half_y)
            axes.set_aspect("equal")
        row[0].set_ylabel("y [µm]")
        bar = figure.colorbar(ScalarMappable(norm, colours), ax=list(row), label=label, aspect=18, pad=0.015)
        ticks = root_ticks(float(norm.vmax or 1.0))
        bar.set_ticks(ticks, labels=[_short(tick) for tick in ticks], minor=False)
    for axes, scar in zip(grid[0], scars, strict=True):
        axes.set_title(f"cycle {cycle_name(scar.cycle)}", pad=16)
    for axes in grid[-1]:
        axes.set_xlabel("x, sliding [µm]")
    sliding_arrow(grid[1, 0])
    scale_bar(grid[0, 0], round_below(0.5 * half_x))
    shown = "pressure at mid-stroke moving towards +x, and distance slid in the cycle"
    body = f"{result.label}, {called(held)}" if result.label else called(held)
    figure.suptitle(f"{body}: {shown}", x=0.01, ha="left", fontsize=9)
    return figure


def touched_half_extent(scars: Sequence[Scar]) -> tuple[float, float]:
    """Largest |x| and |y| [µm] in the sliding frame where the wires touch at mid-stroke or slide on each other.

    At least to the grid points beside the middle, where they touch at one alone.
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
    """Longest way between two samples of a cycle's loop.

    A point under the contact's edge slides all of it or none: averages over it do not depend on where the edge was.
    """
    motion = [loop.displacement_um for loop in result.loops if loop.cycle == cycle]
    return float(abs(np.diff(motion[0])).max(initial=0.0)) if motion else 0.0


def _draw(axes: Axes, scar: Scar, field: str, norm: Normalize, colours: Colormap, over_um: float) -> None:
    axial, transverse, shown = smooth_field(scar, field, over_um)
    x, y = scar.sliding_coordinates(axial[:, None], transverse[None, :])
    axes.pcolormesh(x, y, shown, norm=norm, cmap=colours, shading="nearest", rasterized=True)
    axes.grid(visible=False)
    axes.spines[:].set_visible(True)


def _short(value: float) -> str:
    return f"{value:.0f}" if value >= 100.0 else f"{value:.3g}"
