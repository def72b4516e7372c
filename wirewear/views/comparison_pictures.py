"""Pictures of a comparison: loops, evolution, scars. Measured is grey with the repeats' range, simulated is blue."""

from collections.abc import Sequence

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wirewear.loops import LoopFigures, Measured
from wirewear.pictures.colours import GREY, INK, VARIANT_COLOURS
from wirewear.pictures.smooth import chosen_cycles
from wirewear.pictures.style import cycle_axis, cycle_name, new_figure, panel_letters
from wirewear.records.values import Array, ExperimentRecord
from wirewear.results import RunResult
from wirewear.views.differences import EVOLUTION_FIGURES, common_evolution
from wirewear.views.matched_loops import PHASES, LoopPair

SIMULATED, MEASURED, BAND = VARIANT_COLOURS[0], INK, "#c9c9c9"

MOST_PANELS, COLUMNS = 6, 3

#: Friction measures, their marks, and whether simulated and measured differ in colour.
FRICTION = (
    ("friction_max", "largest Q/P", "^"),
    ("friction_energy", "from energy", "s"),
    ("friction_geometry_independent", "geometry-independent", "o"),
)


def loops_picture(pairs: Sequence[LoopPair]) -> Figure:
    """Loops at matching cycles, one panel each, all on the same axes."""
    chosen = chosen_cycles([pair.cycle for pair in pairs], MOST_PANELS)
    shown = [pair for pair in pairs if pair.cycle in chosen]
    columns = 2 if len(shown) == 4 else min(len(shown), COLUMNS)
    rows = -(-len(shown) // columns)
    figure = new_figure((2.6 if columns == COLUMNS else 3.0) * rows + 0.5 if columns > 1 else 4.2)
    panels = list(figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).flat)
    for unused in panels[len(shown) :]:
        unused.set_visible(False)
    for axes, pair in zip(panels, shown, strict=False):
        _draw_pair(axes, pair)
        axes.label_outer()
    for place in range(max(len(shown) - columns, 0), len(shown)):
        panels[place].xaxis.set_tick_params(labelbottom=True)
        panels[place].set_xlabel("displacement δ [µm]")
    for place in range(0, len(shown), columns):
        panels[place].set_ylabel("tangential force Q [N]")
    if len(shown) > 1:
        panel_letters(panels[: len(shown)])
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    return figure


def _draw_pair(axes: Axes, pair: LoopPair) -> None:
    x, q = pair.measured[:, 0], pair.measured[:, 1]
    middle = x.mean(axis=0)
    count = len(pair.repeats)
    if count > 1:
        half = np.arange(PHASES // 4, PHASES // 4 + PHASES // 2)
        for branch in (half, (half + PHASES // 2) % PHASES):
            low, high = q[:, branch].min(axis=0), q[:, branch].max(axis=0)
            axes.fill_between(middle[branch], low, high, color=BAND, linewidth=0)
        axes.fill_between([], [], [], color=BAND, linewidth=0, label=f"range of {count} repeats")
    closed = [np.append(values, values[0]) for values in (middle, q.mean(axis=0))]
    axes.plot(*closed, color=MEASURED, linewidth=0.8, label="measured, mean" if count > 1 else "measured")
    closed = [np.append(values, values[0]) for values in pair.simulated]
    axes.plot(*closed, color=SIMULATED, linewidth=1.4, label="simulated")
    axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    axes.axvline(0.0, color=GREY, linewidth=0.6, zorder=1)
    axes.set_title(f"cycle {cycle_name(pair.cycle)}")


def evolution_picture(result: RunResult, record: ExperimentRecord, pairs: Sequence[LoopPair]) -> Figure:
    """Amplitudes, energy, largest force and friction measures over the cycles."""
    figure = new_figure(5.6)
    grid = figure.subplots(2, 2)
    names = {name: quantity for quantity, _, name in EVOLUTION_FIGURES}
    for axes, columns, label in (
        (grid[0, 0], ("displacement_amplitude_um", "slip_amplitude_um"), "amplitude [µm]"),
        (grid[0, 1], ("dissipated_energy_mJ",), "energy per cycle $E_d$ [mJ]"),
        (grid[1, 0], ("max_tangential_force_N",), "largest tangential force [N]"),
    ):
        for column in columns:
            _draw_column(axes, result, record, column, pairs)
        axes.set_title("δa and δ0" if len(columns) > 1 else names[columns[0]])
        axes.set_ylabel(label)
        cycle_axis(axes)
    _draw_friction(grid[1, 1], pairs)
    handles: dict[str, Artist] = {}
    for axes in (grid[0, 0], grid[0, 1]):
        handles |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    panel_letters(list(grid.flat))
    figure.legend(list(handles.values()), list(handles), loc="outside upper center", ncols=3)
    return figure


def _draw_column(axes: Axes, result: RunResult, record: ExperimentRecord, name: str, pairs: Sequence[LoopPair]) -> None:
    cycles, tests = common_evolution(record, name)
    if cycles.size:
        if len(tests) > 1:
            low, high = tests.min(axis=0), tests.max(axis=0)
            axes.fill_between(cycles, low, high, color=BAND, linewidth=0, label=f"range of {len(tests)} repeats")
        label = "measured, mean" if len(tests) > 1 else "measured"
        axes.plot(cycles, tests.mean(axis=0), color=MEASURED, linewidth=0.8, label=label)
    else:
        _draw_of_loops(axes, name, pairs)
    simulated = result.evolution["cycle"]
    axes.plot(simulated, result.evolution[name], color=SIMULATED, linewidth=1.4, label="simulated")


def _draw_of_loops(axes: Axes, name: str, pairs: Sequence[LoopPair]) -> None:
    """Figures of the measured loops, where the record has no evolution."""

    def value(pair: LoopPair, test: int) -> float:
        if name == "max_tangential_force_N":
            return float(np.abs(pair.measured[test, 1]).max())
        figure: Measured = getattr(pair.measured_figures[test], name)
        return figure.value

    points = [(pair.cycle, value(pair, test)) for pair in pairs for test in range(len(pair.repeats))]
    axes.plot(*zip(*points, strict=True), "o", color=MEASURED, markersize=3.5, label="measured loops")


def _draw_friction(axes: Axes, pairs: Sequence[LoopPair]) -> None:
    for attribute, label, mark in FRICTION:
        rows = [(pair.cycle, *_friction(pair, attribute)) for pair in pairs]
        rows = [row for row in rows if np.isfinite(row[1]) and row[2].size]
        if not rows:
            continue
        cycles = np.array([row[0] for row in rows], dtype=float)
        axes.plot(cycles, [row[1] for row in rows], color=SIMULATED, linewidth=1.0, marker=mark, markersize=4)
        means = np.array([row[2].mean() for row in rows])
        reach = np.array([[row[2].mean() - row[2].min(), row[2].max() - row[2].mean()] for row in rows]).T
        axes.errorbar(
            cycles, means, reach, color=MEASURED, linestyle="none", marker=mark, markersize=4, capsize=2, linewidth=0.8,
            markerfacecolor="white",
        )  # fmt: skip
        axes.plot([], [], color=GREY, linestyle="none", marker=mark, markersize=4, label=label)
    axes.set_title("coefficients of friction")
    axes.set_ylabel("coefficient of friction [–]")
    cycle_axis(axes)
    axes.legend(loc="best")


def _friction(pair: LoopPair, attribute: str) -> tuple[float, Array]:
    def value(figures: LoopFigures) -> float:
        measured: Measured | None = getattr(figures, attribute)
        return np.nan if measured is None else measured.value

    tests = np.array([value(figures) for figures in pair.measured_figures])
    return value(pair.simulated_figures), tests[np.isfinite(tests)]
