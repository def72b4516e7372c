"""Fretting loops: tangential force against displacement."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wirewear.pictures.style import cycle_colours, cycle_name, new_figure, panel_letters, variant_style
from wirewear.results import Loop, RunResult

MOST_LOOPS = 6
PANELS_IN_A_ROW = 3


def chosen_cycles(logged: Sequence[int], most: int = MOST_LOOPS) -> tuple[int, ...]:
    """At most `most` of the logged cycles: the last, and the first and the decades before it, evenly thinned."""
    cycles = sorted(set(logged))
    decades = [c for c in cycles if 10 ** round(np.log10(max(c, 1))) == c]
    wanted = cycles if len(cycles) <= most else sorted({cycles[0], *decades, cycles[-1]})
    places = np.unique(np.linspace(0, len(wanted) - 1, min(most, len(wanted))).round().astype(int))
    return tuple(wanted[place] for place in places)


def loops_by_run(results: Sequence[RunResult]) -> Figure:
    """One panel for each run, its loops at chosen cycles in colour; all panels on the same axes."""
    figure, panels = _panels(len(results))
    cycles = chosen_cycles([loop.cycle for result in results for loop in result.loops])
    colours = dict(zip(cycles, cycle_colours(len(cycles)), strict=True))
    for axes, result in zip(panels, results, strict=True):
        for loop in result.loops:
            if loop.cycle in colours:
                _draw_loop(axes, loop, color=colours[loop.cycle])
        axes.set_title(result.label)
    _finish(panels)
    for cycle, colour in colours.items():
        panels[0].plot([], [], color=colour, label=cycle_name(cycle))
    figure.legend(*panels[0].get_legend_handles_labels(), title="cycle", loc="outside right upper", alignment="left")
    return figure


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
    closed = [np.append(values, values[0]) for values in (loop.displacement_um, loop.tangential_force_N)]
    axes.plot(*closed, **line)  # type: ignore[arg-type]


def _finish(panels: Sequence[Axes]) -> None:
    for axes in panels:
        axes.axhline(0.0, color="#8a8a8a", linewidth=0.6, zorder=1)
        axes.axvline(0.0, color="#8a8a8a", linewidth=0.6, zorder=1)
        axes.set_xlabel("displacement δ [µm]")
        axes.label_outer()
    panels[0].set_ylabel("tangential force Q [N]")
    if len(panels) > 1:
        panel_letters(panels)
