"""Fretting loops: tangential force against displacement."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from wirewear.pictures.colours import GREY
from wirewear.pictures.smooth import chosen_cycles, smooth_loop
from wirewear.pictures.style import cycle_colours, cycle_name, new_figure, panel_letters, variant_style
from wirewear.results import Loop, RunResult

PANELS_IN_A_ROW = 3

#: Line widths of the first and the last loop [points].
WIDEST, THINNEST = 1.8, 1.1


def loops_by_run(results: Sequence[RunResult], unit: str = "N") -> Figure:
    """One panel for each run, its loops at chosen cycles in colour; all panels on the same axes. unit: of forces."""
    figure, panels = _panels(len(results))
    cycles = chosen_cycles([loop.cycle for result in results for loop in result.loops])
    for axes, result in zip(panels, results, strict=True):
        draw_loops(axes, result, cycles)
        axes.set_title(result.label)
    _finish(panels, unit)
    keys = [
        Line2D([], [], color=colour, linewidth=width, label=cycle_name(cycle))
        for cycle, colour, width in zip(cycles, cycle_colours(len(cycles)), _widths(len(cycles)), strict=True)
    ]
    figure.legend(handles=keys, title="cycle", loc="outside right upper", alignment="left")
    return figure


def draw_loops(axes: Axes, result: RunResult, cycles: Sequence[int] | None = None) -> None:
    """Loops of one run at these cycles, by default some of those that it has logged.

    Earlier loops are drawn broader below later ones, so that loops which coincide are seen to.
    """
    chosen = chosen_cycles([loop.cycle for loop in result.loops]) if cycles is None else cycles
    logged = {loop.cycle: loop for loop in result.loops}
    for cycle, colour, width in zip(chosen, cycle_colours(len(chosen)), _widths(len(chosen)), strict=True):
        if cycle in logged:
            _draw_loop(axes, logged[cycle], color=colour, linewidth=width, label=cycle_name(cycle))
    if cycles is None:
        axes.legend(loc="center", title="cycle", fontsize=6.5, title_fontsize=6.5, handlelength=1.4, ncols=2)
        _name_axes(axes)


def loops_by_cycle(results: Sequence[RunResult], cycles: Sequence[int]) -> Figure:
    """One panel for each cycle, the runs overlaid; all panels on the same axes.

    Raises:
        ResultError: a run has logged no loop near one of the cycles.
    """
    figure, panels = _panels(len(cycles))
    for axes, cycle in zip(panels, cycles, strict=True):
        for index, result in enumerate(results):
            _draw_loop(axes, result.loop(cycle), **variant_style(index), label=result.label)
        axes.set_title(f"cycle {cycle_name(results[0].loop(cycle).cycle)}")
    _finish(panels)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside right upper", alignment="left")
    return figure


def _panels(count: int) -> tuple[Figure, list[Axes]]:
    columns = min(count, PANELS_IN_A_ROW)
    rows = -(-count // columns)
    figure = new_figure(3.1 * rows if columns > 1 else 3.8)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    panels = list(grid.flat)
    for unused in panels[count:]:
        unused.set_visible(False)
    return figure, panels[:count]


def _draw_loop(axes: Axes, loop: Loop, **line: object) -> None:
    axes.plot(*smooth_loop(loop), solid_capstyle="butt", **line)  # type: ignore[arg-type]


def _widths(count: int) -> list[float]:
    """One line width for each of `count` cycles, the last the thinnest."""
    return [float(width) for width in np.linspace(WIDEST, THINNEST, count)] if count > 1 else [THINNEST]


def _name_axes(axes: Axes, unit: str = "N") -> None:
    axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    axes.axvline(0.0, color=GREY, linewidth=0.6, zorder=1)
    axes.set_xlabel("displacement δ [µm]")
    axes.set_ylabel(f"tangential force Q [{unit}]")


def _finish(panels: Sequence[Axes], unit: str = "N") -> None:
    for axes in panels:
        _name_axes(axes, unit)
        axes.label_outer()
    if len(panels) > 1:
        panel_letters(panels)
