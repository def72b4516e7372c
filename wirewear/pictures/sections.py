"""Sections through both scars along the motion axis."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wirewear.pictures.colours import GREY
from wirewear.pictures.smooth import smooth_scar
from wirewear.pictures.style import WIDTH_in, cycle_name, new_figure, panel_letters, round_below, variant_style
from wirewear.results import RunResult, Scar
from wirewear.results.checks import FloatArray
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


def _draw_section(axes: Axes, results: Sequence[RunResult], scars: Sequence[Scar], x: FloatArray) -> None:
    unworn, _ = profile(scars[0], x)
    axes.plot(x, unworn, color=GREY, linewidth=1.0, linestyle=(0, (3, 2)), label="unworn")
    for index, (result, scar) in enumerate(zip(results, scars, strict=True)):
        unworn, worn = profile(scar, x)
        style = variant_style(index)
        axes.fill_between(x, worn, unworn, color=style["color"], alpha=0.12, linewidth=0)
        axes.plot(x, worn, **style, label=result.label)


def profile(scar: Scar, x: FloatArray) -> tuple[FloatArray, FloatArray]:
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
