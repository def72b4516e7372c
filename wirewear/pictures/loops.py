"""Fretting loops: tangential force against displacement."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from scipy.interpolate import PchipInterpolator

from wirewear.pictures.style import GREY, cycle_colours, cycle_name, new_figure, panel_letters, variant_style
from wirewear.results import Loop, RunResult
from wirewear.results.checks import FloatArray

MOST_LOOPS = 6
PANELS_IN_A_ROW = 3

#: Points along a smooth loop, beside its samples; loops of fewer samples are drawn as they are.
POINTS, CLOSED_FROM = 400, 5

#: Line widths of the first and the last loop [points].
WIDEST, THINNEST = 4.2, 1.1


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
    for axes, result in zip(panels, results, strict=True):
        draw_loops(axes, result, cycles)
        axes.set_title(result.label)
    _finish(panels)
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


def smooth_loop(loop: Loop, points: int = POINTS) -> tuple[FloatArray, FloatArray]:
    """Displacement [µm] and force [N] of the closed loop through all of its samples, see `smooth_curve`."""
    return smooth_curve(loop.displacement_um, loop.tangential_force_N, points)


def smooth_curve(displacement_um: FloatArray, force: FloatArray, points: int = POINTS) -> tuple[FloatArray, FloatArray]:
    """A closed loop through all of its samples (n,), with at least `points` points of each coordinate.

    Monotone cubics over the length along the loop; nothing is drawn beyond neighbouring samples.
    """
    x, q = (np.append(values, values[0]) for values in (displacement_um, force))
    lengths = np.hypot(*(np.diff(values) / (np.ptp(values) or 1.0) for values in (x, q)))
    passed = np.concatenate([[True], lengths > 0.0])
    if passed.sum() < CLOSED_FROM:
        return x, q
    x, q, lengths = x[passed], q[passed], lengths[lengths > 0.0]
    at = np.concatenate([[0.0], np.cumsum(lengths)])
    around = np.concatenate([at[-4:-1] - at[-1], at, at[-1] + at[1:4]])
    fine = np.unique(np.concatenate([np.linspace(0.0, at[-1], points), at]))
    curves = (PchipInterpolator(around, np.concatenate([v[-4:-1], v, v[1:4]]))(fine) for v in (x, q))
    one, other = curves
    one[-1], other[-1] = one[0], other[0]
    return one, other


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
    axes.plot(*smooth_loop(loop), **line)  # type: ignore[arg-type]


def _widths(count: int) -> list[float]:
    """One line width for each of `count` cycles, the last the thinnest."""
    return [float(width) for width in np.linspace(WIDEST, THINNEST, count)] if count > 1 else [THINNEST]


def _name_axes(axes: Axes) -> None:
    axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    axes.axvline(0.0, color=GREY, linewidth=0.6, zorder=1)
    axes.set_xlabel("displacement δ [µm]")
    axes.set_ylabel("tangential force Q [N]")


def _finish(panels: Sequence[Axes]) -> None:
    for axes in panels:
        _name_axes(axes)
        axes.label_outer()
    if len(panels) > 1:
        panel_letters(panels)
