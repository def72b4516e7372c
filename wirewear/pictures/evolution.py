"""What changes over the cycles: amplitudes, depth, energy, force."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from wirewear.pictures.colours import GREY, INK
from wirewear.pictures.style import cycle_axis, new_figure, panel_letters, variant_style
from wirewear.results import RunResult
from wirewear.results.scar import called

#: Lines of the driven and the held body where colours stand for runs.
DASHES: tuple[Any, Any] = ((0, (5, 1.5)), "-")


def amplitude_evolution(results: Sequence[RunResult]) -> Figure:
    """Displacement amplitude δa and slip amplitude δ0 over the cycles, all runs overlaid."""
    figure = new_figure(3.3)
    axes = figure.subplots()
    draw_amplitudes(axes, results)
    axes.set_title("")
    figure.legend(loc="outside right upper", alignment="left")
    return figure


def evolution_panels(results: Sequence[RunResult]) -> Figure:
    """Four panels over the cycles: amplitudes, deepest points of both scars, energy per cycle, largest force."""
    figure = new_figure(5.4)
    panels = list(figure.subplots(2, 2).flat)
    draw_amplitudes(panels[0], results)
    draw_depths(panels[1], results)
    for axes, column, title, label in (
        (panels[2], "dissipated_energy_mJ", "friction energy", "energy per cycle $E_d$ [mJ]"),
        (panels[3], "max_tangential_force_N", "peak force", "largest tangential force [N]"),
    ):
        for index, result in enumerate(results):
            axes.plot(result.evolution["cycle"], result.evolution[column], **variant_style(index))
        axes.set_title(title)
        axes.set_ylabel(label)
        cycle_axis(axes)
        _widen(axes)
    panel_letters(panels)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=min(len(labels), 4))
    return figure


def draw_amplitudes(axes: Axes, results: Sequence[RunResult]) -> None:
    """Displacement and slip amplitude over the cycles."""
    for index, result in enumerate(results):
        columns = result.evolution
        style = variant_style(index)
        axes.plot(columns["cycle"], columns["slip_amplitude_um"], **style, label=f"{result.label}: slip δ0")
    axes.plot([], [], color=INK, linewidth=1.0, label="displacement δa")
    for result in results:
        columns = result.evolution
        axes.plot(columns["cycle"], columns["displacement_amplitude_um"], color=INK, linewidth=1.0)
    axes.set_title("displacement and slip amplitude")
    axes.set_ylabel("amplitude [µm]")
    cycle_axis(axes)
    _widen(axes)


def draw_depths(axes: Axes, results: Sequence[RunResult]) -> None:
    """Deepest wear of each body over the cycles."""
    lines = list(zip(results[0].bodies, DASHES, strict=True))[::-1]
    for index, result in enumerate(results):
        colour = variant_style(index)["color"]
        for body, dashes in lines:
            depth = result.evolution[f"max_depth_{body}_um"]
            axes.plot(result.evolution["cycle"], np.where(depth > 0.0, depth, np.nan), color=colour, linestyle=dashes)
    for body, dashes in lines:
        axes.plot([], [], color=GREY, linestyle=dashes, label=called(body))
    axes.legend(loc="upper left")
    axes.set_title("worst depth")
    axes.set_ylabel("depth [µm]")
    cycle_axis(axes)
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
