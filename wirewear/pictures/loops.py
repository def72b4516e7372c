"""Fretting loops, and what changes over the cycles: amplitudes, depth, energy, force."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter

from wirewear.pictures import style
from wirewear.pictures.smooth import chosen_cycles, smooth_loop
from wirewear.results import Loop, RunResult
from wirewear.results.scar import called

DASHES: tuple[Any, Any] = ((0, (5, 1.5)), "-")  #: Lines of the driven and the held body where colours stand for runs.


def amplitude_evolution(results: Sequence[RunResult]) -> Figure:
    """Displacement amplitude δa and slip amplitude δ0 over the cycles, all runs overlaid."""
    figure = style.new_figure(3.3)
    axes = figure.subplots()
    draw_amplitudes(axes, results)
    axes.set_title("")
    figure.legend(loc="outside right upper", alignment="left")
    return figure


def evolution_panels(results: Sequence[RunResult]) -> Figure:
    """Four panels over the cycles: amplitudes, deepest points of both scars, energy per cycle, largest force."""
    figure = style.new_figure(5.4)
    panels = list(figure.subplots(2, 2).flat)
    draw_amplitudes(panels[0], results)
    draw_depths(panels[1], results)
    for axes, column, title, label in (
        (panels[2], "dissipated_energy_mJ", "friction energy", "energy per cycle $E_d$ [mJ]"),
        (panels[3], "max_tangential_force_N", "peak force", "largest tangential force [N]"),
    ):
        for index, result in enumerate(results):
            axes.plot(result.evolution["cycle"], result.evolution[column], **style.variant_style(index))
        axes.set(title=title, ylabel=label)
        style.cycle_axis(axes)
        _widen(axes)
    style.panel_letters(panels)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=min(len(labels), 4))
    return figure


def draw_amplitudes(axes: Axes, results: Sequence[RunResult]) -> None:
    """Displacement and slip amplitude over the cycles."""
    for index, result in enumerate(results):
        columns = result.evolution
        look = style.variant_style(index)
        axes.plot(columns["cycle"], columns["slip_amplitude_um"], **look, label=f"{result.label}: slip δ0")
    axes.plot([], [], color=style.INK, linewidth=1.0, label="displacement δa")
    for result in results:
        columns = result.evolution
        axes.plot(columns["cycle"], columns["displacement_amplitude_um"], color=style.INK, linewidth=1.0)
    axes.set(title="displacement and slip amplitude", ylabel="amplitude [µm]")
    style.cycle_axis(axes)
    _widen(axes)


def draw_depths(axes: Axes, results: Sequence[RunResult]) -> None:
    """Deepest wear of each body over the cycles."""
    lines = list(zip(results[0].bodies, DASHES, strict=True))[::-1]
    for index, result in enumerate(results):
        colour = style.variant_style(index)["color"]
        for body, dashes in lines:
            depth = result.evolution[f"max_depth_{body}_um"]
            axes.plot(result.evolution["cycle"], np.where(depth > 0.0, depth, np.nan), color=colour, linestyle=dashes)
    for body, dashes in lines:
        axes.plot([], [], color=style.GREY, linestyle=dashes, label=called(body))
    axes.legend(loc="upper left")
    axes.set(title="worst depth", ylabel="depth [µm]")
    style.cycle_axis(axes)
    # A logarithmic axis has no place for a surface that is still unworn.
    if any((result.evolution[f"max_depth_{body}_um"] > 0.0).any() for result in results for body, _ in lines):
        axes.set_yscale("log")
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def _widen(axes: Axes) -> None:
    """A nearly constant curve is no zig-zag: show at least 5 % of its value."""
    low, high = axes.get_ylim()
    middle, least = 0.5 * (low + high), 0.05 * abs(0.5 * (low + high))
    if high - low < least:
        axes.set_ylim(middle - least / 2, middle + least / 2)


PANELS_IN_A_ROW = 3

WIDEST, THINNEST = 1.8, 1.1  #: Line widths of the first and the last loop [points].


def loops_by_run(results: Sequence[RunResult], unit: str = "N") -> Figure:
    """One panel for each run, its loops at chosen cycles in colour; all panels on the same axes. unit: of forces."""
    figure, panels = _panels(len(results))
    cycles = chosen_cycles([loop.cycle for result in results for loop in result.loops])
    for axes, result in zip(panels, results, strict=True):
        draw_loops(axes, result, cycles)
        axes.set_title(result.label)
    _finish(panels, unit)
    keys = [
        Line2D([], [], color=colour, linewidth=width, label=style.cycle_name(cycle))
        for cycle, colour, width in zip(cycles, style.cycle_colours(len(cycles)), _widths(len(cycles)), strict=True)
    ]
    figure.legend(handles=keys, title="cycle", loc="outside right upper", alignment="left")
    return figure


def draw_loops(axes: Axes, result: RunResult, cycles: Sequence[int] | None = None) -> None:
    """Loops of one run at these cycles, by default some of those that it has logged.

    Earlier loops are drawn broader below later ones, so that loops which coincide are seen to.
    """
    chosen = chosen_cycles([loop.cycle for loop in result.loops]) if cycles is None else cycles
    logged = {loop.cycle: loop for loop in result.loops}
    for cycle, colour, width in zip(chosen, style.cycle_colours(len(chosen)), _widths(len(chosen)), strict=True):
        if cycle in logged:
            _draw_loop(axes, logged[cycle], color=colour, linewidth=width, label=style.cycle_name(cycle))
    if cycles is None:
        axes.legend(loc="center", title="cycle", fontsize=6.5, title_fontsize=6.5, handlelength=1.4, ncols=2)
        _name_axes(axes)


def loops_by_cycle(results: Sequence[RunResult], cycles: Sequence[int]) -> Figure:
    """One panel for each cycle, the runs overlaid; all panels on the same axes.
    Raises ResultError if a run has logged no loop near one of the cycles.
    """
    figure, panels = _panels(len(cycles))
    for axes, cycle in zip(panels, cycles, strict=True):
        for index, result in enumerate(results):
            _draw_loop(axes, result.loop(cycle), **style.variant_style(index), label=result.label)
        axes.set_title(f"cycle {style.cycle_name(results[0].loop(cycle).cycle)}")
    _finish(panels)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside right upper", alignment="left")
    return figure


def _panels(count: int) -> tuple[Figure, list[Axes]]:
    columns = min(count, PANELS_IN_A_ROW)
    rows = -(-count // columns)
    figure = style.new_figure(3.1 * rows if columns > 1 else 3.8)
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
    axes.axhline(0.0, color=style.GREY, linewidth=0.6, zorder=1)
    axes.axvline(0.0, color=style.GREY, linewidth=0.6, zorder=1)
    axes.set(xlabel="displacement δ [µm]", ylabel=f"tangential force Q [{unit}]")


def _finish(panels: Sequence[Axes], unit: str = "N") -> None:
    for axes in panels:
        _name_axes(axes, unit)
        axes.label_outer()
    if len(panels) > 1:
        style.panel_letters(panels)
