"""Pictures of a comparison: loops, evolution, scars. Measured values are black with a grey range of repeats, simulated
ones blue.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, Normalize
from matplotlib.figure import Figure

from geometry.arrays import Array
from wirewear.comparison.differences import EVOLUTION_FIGURES, LoopPair, common_evolution
from wirewear.comparison.registration import ScarPair
from wirewear.loops import LoopFigures, Measured
from wirewear.pictures import style
from wirewear.pictures.panels import DISPLACEMENT, draw_loop, draw_loop_band, draw_map, name_axes
from wirewear.pictures.smooth import chosen_cycles
from wirewear.records import AnyRecord
from wirewear.results import RunResult

SIMULATED, MEASURED, BAND = style.VARIANT_COLOURS[0], style.INK, "#c9c9c9"

MOST_PANELS, COLUMNS = 6, 3
MAP_in = 3.4  #: Width of a map that stands by itself.

DIFFERENCE_COLOURS = "RdBu_r"  #: Blue where the simulation wears too little, red where it wears too much.

#: Friction measures, their marks, and whether simulated and measured differ in colour.
FRICTION = (
    ("friction_max", "largest Q/P", "^"),
    ("friction_energy", "from energy", "s"),
    ("friction_geometry_independent", "geometry-independent", "o"),
)


def loops_picture(pairs: Sequence[LoopPair]) -> Figure:
    """Figure with the loops of up to six matched cycles, one panel each, all on the same axes; needs at least one
    pair.
    """
    chosen = chosen_cycles([pair.cycle for pair in pairs], MOST_PANELS)
    shown = [pair for pair in pairs if pair.cycle in chosen]
    columns = 2 if len(shown) == 4 else min(len(shown), COLUMNS)
    rows = -(-len(shown) // columns)
    figure = style.new_figure((2.6 if columns == COLUMNS else 3.0) * rows + 0.5 if columns > 1 else 4.2)
    panels = list(figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).flat)
    for unused in panels[len(shown) :]:
        unused.set_visible(False)
    for axes, pair in zip(panels, shown, strict=False):
        _draw_pair(axes, pair)
        axes.label_outer()
    for place in range(max(len(shown) - columns, 0), len(shown)):
        panels[place].xaxis.set_tick_params(labelbottom=True)
        panels[place].set_xlabel(DISPLACEMENT)
    if len(shown) > 1:
        style.panel_letters(panels[: len(shown)])
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    return figure


def _draw_pair(axes: Axes, pair: LoopPair) -> None:
    x, q = pair.measured[:, 0], pair.measured[:, 1]
    middle = x.mean(axis=0)
    count = len(pair.repeats)
    if count > 1:
        draw_loop_band(axes, middle, q.min(axis=0), q.max(axis=0), color=BAND)
        axes.fill_between([], [], [], color=BAND, linewidth=0, label=f"range of {count} repeats")
    label = "measured, mean" if count > 1 else "measured"
    draw_loop(axes, middle, q.mean(axis=0), color=MEASURED, linewidth=0.8, label=label)
    draw_loop(axes, *pair.simulated, color=SIMULATED, linewidth=1.4, label="simulated")
    name_axes(axes)
    axes.set_title(f"cycle {style.cycle_name(pair.cycle)}")


def evolution_picture(result: RunResult, record: AnyRecord, pairs: Sequence[LoopPair]) -> Figure:
    """Figure of amplitudes, energy, largest force and friction over the cycles, simulated and measured. pairs: matched
    loops, which show friction, and stand in for columns that the record's evolution lacks.
    """
    figure = style.new_figure(5.6)
    grid = figure.subplots(2, 2)
    names = {name: quantity for quantity, _, name in EVOLUTION_FIGURES}
    for axes, columns, label in (
        (grid[0, 0], ("displacement_amplitude_um", "slip_amplitude_um"), "amplitude [µm]"),
        (grid[0, 1], ("dissipated_energy_mJ",), "energy per cycle $E_d$ [mJ]"),
        (grid[1, 0], ("max_tangential_force_N",), "largest tangential force [N]"),
    ):
        for column in columns:
            _draw_column(axes, result, record, column, pairs)
        axes.set(title="δa and δ0" if len(columns) > 1 else names[columns[0]], ylabel=label)
        style.cycle_axis(axes)
    _draw_friction(grid[1, 1], pairs)
    handles: dict[str, Artist] = {}
    for axes in (grid[0, 0], grid[0, 1]):
        handles |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    style.panel_letters(list(grid.flat))
    figure.legend(list(handles.values()), list(handles), loc="outside upper center", ncols=3)
    return figure


def _draw_column(axes: Axes, result: RunResult, record: AnyRecord, name: str, pairs: Sequence[LoopPair]) -> None:
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
    """Draw a figure of the measured loops over the cycles, for records without an evolution."""

    def value(pair: LoopPair, test: int) -> float:
        if name == "max_tangential_force_N":
            return float(np.abs(pair.measured[test, 1]).max())
        figure: Measured = getattr(pair.measured_figures[test], name)
        return figure.value

    points = [(pair.cycle, value(pair, test)) for pair in pairs for test in range(len(pair.repeats))]
    axes.plot(
        [cycle for cycle, _ in points],
        [one for _, one in points],
        "o",
        color=MEASURED,
        markersize=3.5,
        label="measured loops",
    )


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
        axes.plot([], [], color=style.GREY, linestyle="none", marker=mark, markersize=4, label=label)
    axes.set(title="coefficients of friction", ylabel="coefficient of friction [–]")
    style.cycle_axis(axes)
    axes.legend(loc="best")


def _friction(pair: LoopPair, attribute: str) -> tuple[float, Array]:
    def value(figures: LoopFigures) -> float:
        measured: Measured | None = getattr(figures, attribute)
        return np.nan if measured is None else measured.value

    tests = np.array([value(figures) for figures in pair.measured_figures])
    return value(pair.simulated_figures), tests[np.isfinite(tests)]


@dataclass(frozen=True, eq=False)
class DepthMap:
    """One depth map of a comparison with its colours.

    what: "measured", "simulated" or "difference". label: of the colour scale. half_um: half extents in x and y, common
    to all maps.
    """

    pair: ScarPair
    what: str
    depth_um: Array
    colours: Colormap | str
    norm: Normalize
    label: str
    half_um: tuple[float, float]


def depth_maps(pairs: Sequence[ScarPair]) -> list[list[DepthMap]]:
    """For each body's scars, maps of the measured mean, the simulated depth and their difference; each kind has one
    colour scale. pairs: at least one.
    """
    colours, norm = style.depth_scale(depth for pair in pairs for depth in (pair.mean, pair.simulated))
    worst = max(float(np.nanmax(np.abs(pair.simulated - pair.mean))) for pair in pairs) or 1e-3
    half_x, half_y = (max(float(np.abs(getattr(pair, n)).max()) for pair in pairs) for n in ("x_um", "y_um"))
    depth = colours, norm, "worn depth, raised if negative [µm]", (half_x, half_y)
    difference = DIFFERENCE_COLOURS, Normalize(-worst, worst), "simulated − measured [µm]", (half_x, half_y)
    return [
        [
            DepthMap(pair, "measured", pair.mean, *depth),
            DepthMap(pair, "simulated", pair.simulated, *depth),
            DepthMap(pair, "difference", pair.simulated - pair.mean, *difference),
        ]
        for pair in pairs
    ]


def every_map(pairs: Sequence[ScarPair]) -> list[DepthMap]:
    """The maps of `depth_maps` in one list; empty without pairs."""
    return [shown for row in depth_maps(pairs) for shown in row] if pairs else []


def maps_picture(pairs: Sequence[ScarPair]) -> Figure:
    """Figure of the maps of `depth_maps`, one row for each body; needs at least one pair."""
    rows = depth_maps(pairs)
    half_x, half_y = rows[0][0].half_um
    panel_in = 0.80 * style.WIDTH_in / 3
    figure = style.new_figure(len(pairs) * (panel_in * half_y / half_x + 0.45) + 1.3)
    grid = figure.subplots(len(pairs), 3, sharex=True, sharey=True, squeeze=False)
    for row, maps in zip(grid, rows, strict=True):
        for axes, shown in zip(row, maps, strict=True):
            _draw_map(axes, shown)
        row[0].set_ylabel(f"{maps[0].pair.name}\ny [µm]")
    for axes, shown in zip(grid[0], rows[0], strict=True):
        axes.set_title(shown.what)
    for axes in grid[-1]:
        axes.set_xlabel("x, sliding [µm]")
    for columns, shown in ((grid[:, :2], rows[0][0]), (grid[:, 2:], rows[0][2])):
        bar = ScalarMappable(shown.norm, shown.colours)
        wide = columns.shape[1] > 1
        figure.colorbar(bar, ax=columns, label=shown.label, location="bottom", aspect=40 if wide else 20)
    return figure


def map_picture(shown: DepthMap) -> Figure:
    """Figure of one map alone, in its colours, with its colour scale."""
    half_x, half_y = shown.half_um
    figure = style.new_figure(MAP_in * min(max(half_y / half_x, 0.4), 1.6) + 0.9, MAP_in)
    axes = figure.subplots()
    _draw_map(axes, shown)
    axes.set(title=f"{shown.pair.name}, {shown.what}", xlabel="x, sliding [µm]", ylabel="y [µm]")
    figure.colorbar(ScalarMappable(shown.norm, shown.colours), ax=axes, label=shown.label, location="bottom")
    return figure


def _draw_map(axes: Axes, shown: DepthMap) -> None:
    at = shown.pair.x_um, shown.pair.y_um
    draw_map(axes, at, shown.depth_um, shown.norm, shown.colours, shown.half_um, shading="gouraud")
    style.scale_bar(axes, style.round_below(0.4 * shown.half_um[0]))


def sections_picture(pairs: Sequence[ScarPair]) -> Figure:
    """Figure of depths along the motion through the origin and, for maps, also across it; one row for each body, all to
    one scale; needs at least one pair.
    """
    figure = style.new_figure(2.1 * len(pairs) + 0.7)
    grid = figure.subplots(len(pairs), 2 if pairs[0].is_map else 1, sharex=True, sharey=True, squeeze=False)
    for row, pair in zip(grid, pairs, strict=True):
        cuts = [(pair.x_um, pair.section_along), (pair.y_um, pair.section_across)]
        for axes, (at, cut) in zip(row, cuts, strict=False):
            _draw_section(axes, at, np.stack([cut(depth) for depth in pair.measured]), cut(pair.simulated))
            axes.set_title(f"{pair.name} across it")
        row[0].set(
            title=f"{pair.name} along the motion, {style.cycle_name(pair.simulated_cycle)} cycles",
            ylabel="worn depth [µm]",
        )
    grid[0, 0].invert_yaxis()
    for axes, label in zip(grid[-1], ("x at y = 0 [µm]", "y at x = 0 [µm]"), strict=False):
        axes.set_xlabel(label)
    style.panel_letters(list(grid.flat))
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    return figure


def _draw_section(axes: Axes, at: Array, tests: Array, simulated: Array) -> None:
    known = np.isfinite(tests).all(axis=0)
    many = len(tests) > 1
    if many:
        low, high = tests[:, known].min(axis=0), tests[:, known].max(axis=0)
        axes.fill_between(at[known], low, high, color=BAND, linewidth=0, label=f"range of {len(tests)} repeats")
    label = "measured, mean" if many else "measured"
    axes.plot(at[known], tests[:, known].mean(axis=0), color=MEASURED, linewidth=0.8, label=label)
    axes.plot(at, simulated, color=SIMULATED, linewidth=1.4, label="simulated")
