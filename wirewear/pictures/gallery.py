"""All pictures of one result or of a folder of variants: loops, evolution over the cycles, scars.

A test by blocks has blocks of cycles under different conditions one after another. Where `results` are taken, there is
at least one.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter
from matplotlib.typing import LineStyleType
from PIL import Image

from geometry.arrays import Array
from wirewear.base.errors import ResultError
from wirewear.base.writing import write_bytes, writing
from wirewear.pictures import style
from wirewear.pictures.panels import draw_loop, draw_scar, name_axes
from wirewear.pictures.scar_maps import contact_maps, profile, scar_sections, scar_series, scars_from_above
from wirewear.pictures.scar_surfaces import scars_in_3d
from wirewear.pictures.smooth import chosen_cycles, smooth_loop, smooth_scar, worn_half_extent
from wirewear.results import RunResult

#: Lines of the driven and the held body where colours stand for runs.
DASHES: tuple[LineStyleType, LineStyleType] = (0, (5, 1.5)), "-"

WIDEST, THINNEST = 1.1, 0.7  #: Line widths of the first and the last loop, as shares of other lines'.
FRAME_ms, LAST_ms, DOTS_PER_INCH = 700, 2500, 100  #: Milliseconds of a frame and of the last one; dots per inch.


def amplitude_evolution(results: Sequence[RunResult]) -> Figure:
    """Picture of displacement amplitude δa and slip amplitude δ0 over the cycles, all runs overlaid."""
    figure = style.new_figure(3.3)
    axes = figure.subplots()
    draw_amplitudes(axes, results)
    axes.set_title("")
    figure.legend(loc="outside right upper", alignment="left")
    return figure


def evolution_panels(results: Sequence[RunResult]) -> Figure:
    """Picture of amplitudes, largest depths, energy per cycle and largest force over the cycles, for all runs."""
    figure = style.new_figure(5.4)
    panels = list(figure.subplots(2, 2).flat)
    draw_amplitudes(panels[0], results)
    draw_depths(panels[1], results)
    for axes, column, title, label in (
        (panels[2], "dissipated_energy_mJ", "friction energy", "energy per cycle $E_d$ [mJ]"),
        (panels[3], "max_tangential_force_N", "peak force", "largest tangential force [N]"),
    ):
        for index, result in enumerate(results):
            _draw_course(axes, result, column, **style.variant_style(index))
        axes.set(title=title, ylabel=label)
        style.cycle_axis(axes)
        _widen(axes)
    style.panel_letters(panels)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=min(len(labels), 4))
    return figure


def _draw_course(axes: Axes, result: RunResult, column: str, *, label: str = "", **look: Any) -> None:
    """Draw a column over the cycles; in a test by blocks one line for each block, with its number at the end."""
    cycles, values, blocks = result.evolution["cycle"], result.evolution[column], _blocks(result)
    for number in np.unique(blocks):
        own = blocks == number
        axes.plot(cycles[own], values[own], **look, marker="." if number else "", label=label or None)
        if number:
            place = {"xytext": (2, 2), "textcoords": "offset points", "fontsize": 7.5, "color": look["color"]}
            axes.annotate(f"{number:.0f}", (cycles[own][-1], values[own][-1]), **place)
        label = ""


def _blocks(result: RunResult) -> Array:
    """Number of the programme's block for each row of the evolution; 0 in a test without blocks."""
    return result.evolution["block"] if "block" in result.evolution else np.zeros(len(result.evolution["cycle"]))


def _shown_cycles(results: Sequence[RunResult]) -> Sequence[int]:
    """Cycles whose loops are shown; in a test by blocks the last logged cycle of each block."""
    logged = {loop.cycle for result in results for loop in result.loops}
    latest = {
        (index, number): int(cycle)
        for index, result in enumerate(results)
        for cycle, number in zip(result.evolution["cycle"], _blocks(result), strict=True)
        if number and int(cycle) in logged
    }
    return sorted(set(latest.values())) or chosen_cycles([loop.cycle for result in results for loop in result.loops])


def draw_amplitudes(axes: Axes, results: Sequence[RunResult]) -> None:
    """Draw displacement and slip amplitude of all runs over the cycles in a panel."""
    for index, result in enumerate(results):
        label = f"{result.label}: slip δ0"
        _draw_course(axes, result, "slip_amplitude_um", **style.variant_style(index), label=label)
    axes.plot([], [], color=style.INK, linewidth=1.0, label="displacement δa")
    for result in results:
        _draw_course(axes, result, "displacement_amplitude_um", color=style.INK, linewidth=1.0)
    axes.set(title="displacement and slip amplitude", ylabel="amplitude [µm]")
    style.cycle_axis(axes)
    _widen(axes)


def draw_depths(axes: Axes, results: Sequence[RunResult]) -> None:
    """Draw the largest worn depth of each body of all runs over the cycles in a panel."""
    lines = list(zip(results[0].bodies, DASHES, strict=True))[::-1]
    for index, result in enumerate(results):
        colour = style.variant_style(index)["color"]
        for body, dashes in lines:
            depth = result.evolution[f"max_depth_{body}_um"]
            axes.plot(result.evolution["cycle"], np.where(depth > 0.0, depth, np.nan), color=colour, linestyle=dashes)
    for body, dashes in lines:
        axes.plot([], [], color=style.GREY, linestyle=dashes, label=results[0].called(body))
    axes.legend(loc="upper left")
    axes.set(title="worst depth", ylabel="depth [µm]")
    style.cycle_axis(axes)
    # A logarithmic axis has no place for a surface that is still unworn.
    if any((result.evolution[f"max_depth_{body}_um"] > 0.0).any() for result in results for body, _ in lines):
        axes.set_yscale("log")
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def _widen(axes: Axes) -> None:
    """Extend the vertical axis to at least 5 % of its middle value, so that a nearly constant curve looks constant."""
    low, high = axes.get_ylim()
    middle, least = 0.5 * (low + high), 0.05 * abs(0.5 * (low + high))
    if high - low < least:
        axes.set_ylim(middle - least / 2, middle + least / 2)


def loops_by_run(results: Sequence[RunResult], unit: str = "N") -> Figure:
    """Picture with a panel for each run, of its loops at chosen cycles, on equal axes. unit: of the forces."""
    figure, panels = _panels(len(results))
    cycles = _shown_cycles(results)
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
    """Draw loops of one run at these cycles, by default at a choice of the logged ones; cycles without a loop are left
    out. Earlier loops are drawn with wider lines below later ones, so that coinciding loops all remain visible.
    """
    chosen = _shown_cycles([result]) if cycles is None else cycles
    logged = {loop.cycle: loop for loop in result.loops}
    for cycle, colour, width in zip(chosen, style.cycle_colours(len(chosen)), _widths(len(chosen)), strict=True):
        if cycle in logged:
            draw_loop(axes, *smooth_loop(logged[cycle]), color=colour, linewidth=width, label=style.cycle_name(cycle))
    if cycles is None:
        axes.legend(loc="center", title="cycle", fontsize=6.5, title_fontsize=6.5, handlelength=1.4, ncols=2)
        name_axes(axes)


def loops_by_cycle(results: Sequence[RunResult], cycles: Sequence[int]) -> Figure:
    """Picture with one panel for each cycle, of the loops of all runs logged nearest to it; all panels have equal axes.

    Raises ResultError if a run has logged no loop near one of the cycles.
    """
    figure, panels = _panels(len(cycles))
    for axes, cycle in zip(panels, cycles, strict=True):
        for index, result in enumerate(results):
            draw_loop(axes, *smooth_loop(result.loop(cycle)), **style.variant_style(index), label=result.label)
        axes.set_title(f"cycle {style.cycle_name(results[0].loop(cycle).cycle)}")
    _finish(panels)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside right upper", alignment="left")
    return figure


def _panels(count: int) -> tuple[Figure, list[Axes]]:
    columns = min(count, 3)
    rows = -(-count // columns)
    figure = style.new_figure(3.1 * rows if columns > 1 else 3.8)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    panels = list(grid.flat)
    for unused in panels[count:]:
        unused.set_visible(False)
    return figure, panels[:count]


def _widths(count: int) -> list[float]:
    shares = np.linspace(WIDEST, THINNEST, count) if count > 1 else [THINNEST]
    return [float(share * mpl.rcParams["lines.linewidth"]) for share in shares]


def _finish(panels: Sequence[Axes], unit: str = "N") -> None:
    for axes in panels:
        name_axes(axes, unit)
        axes.label_outer()
    if len(panels) > 1:
        style.panel_letters(panels)


def overview(results: Sequence[RunResult]) -> Figure:
    """Picture of the first run's loops, and of amplitudes, depths and last sections of the held bodies of all runs.

    Raises ResultError if a run has no measured cycle yet.
    """
    if not all(result.evolution["cycle"].size for result in results):
        raise ResultError("nothing is measured yet, so there is nothing to draw")
    figure = style.new_figure(5.6)
    panels = list(figure.subplots(2, 2).flat)
    draw_loops(panels[0], results[0])
    panels[0].set_title(f"loops of {results[0].label}" if len(results) > 1 else "loops")
    draw_amplitudes(panels[1], results)
    draw_depths(panels[2], results)
    _draw_last_sections(panels[3], results)
    style.panel_letters(panels)
    handles, labels = panels[1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=min(len(labels), 4))
    return figure


def _draw_last_sections(axes: Axes, results: Sequence[RunResult]) -> None:
    with_scars = [(index, result) for index, result in enumerate(results) if result.scar_cycles()]
    for index, result in with_scars:
        scar = smooth_scar(result.scar(result.scar_cycles()[-1], result.bodies[1]))
        reach, _ = scar.section_along_motion()
        x = np.linspace(reach[0], reach[-1], 401)
        unworn, worn = profile(scar, x)
        if index == with_scars[0][0]:
            axes.plot(x, unworn, color=style.GREY, linewidth=1.0, linestyle=(0, (3, 2)))
        axes.plot(x, worn, **style.variant_style(index))
        axes.set_title(f"{with_scars[0][1].called(scar.body)}, {style.cycle_name(scar.cycle)} cycles")
    axes.set(xlabel="position along the motion x [µm]", ylabel="height z [µm]")


def animation(result: RunResult, path: Path) -> Path:
    """Write loop and held body's scar over the cycles as an animated GIF to `path`, and return that.

    Raises ResultError if no cycle has both a loop and scars, or the file cannot be written.
    """
    cycles = sorted(set(result.scar_cycles()) & {loop.cycle for loop in result.loops})
    if not cycles:
        raise ResultError("no loop and scars of one cycle are recorded, so that nothing can be shown in motion")
    frames = []
    with style.styled():
        for cycle in cycles:
            image = BytesIO()
            _frame(result, cycle, cycles).savefig(image, format="png", dpi=DOTS_PER_INCH)
            frames.append(Image.open(image).convert("RGB"))
    # The last frame has every colour of the scale.
    palette = frames[-1].quantize(255)
    first, *others = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    durations = [FRAME_ms] * (len(frames) - 1) + [LAST_ms]
    moving = BytesIO()
    first.save(moving, format="GIF", save_all=True, append_images=others, duration=durations, loop=0)
    with writing(ResultError, f"cannot write the moving picture {path}"):
        path.parent.mkdir(parents=True, exist_ok=True)
        return write_bytes(path, moving.getvalue())


def _frame(result: RunResult, cycle: int, cycles: Sequence[int]) -> Figure:
    """Figure with the loop and scar of one cycle, on axes and a colour scale common to all `cycles`."""
    scars = [result.scar(one, result.bodies[1]) for one in cycles]
    half_x, half_y = (1.25 * half for half in worn_half_extent(scars))
    norm = Normalize(0.0, max(scar.max_depth_um for scar in scars) or 1.0)
    figure = style.new_figure(3.2)
    left, right = figure.subplots(1, 2)
    curves = {one: smooth_loop(result.loop(one)) for one in cycles}
    draw_loop(left, *curves[cycles[0]], color=style.GREY, linewidth=0.9)
    draw_loop(left, *curves[cycle], color=style.VARIANT_COLOURS[0])
    for axis, values in (("x", 0), ("y", 1)):
        reach = 1.06 * max(float(np.abs(curve[values]).max()) for curve in curves.values())
        getattr(left, f"set_{axis}lim")(-reach, reach)
    name_axes(left)
    left.set_title(f"{result.label}: cycle {style.cycle_name(cycle)}")
    scar = result.scar(cycle, result.bodies[1])
    draw_scar(right, scar, half_x, half_y, norm)
    right.set(title=f"{result.called(scar.body)}, deepest {scar.max_depth_um:.3g} µm", xlabel="x [µm]", ylabel="y [µm]")
    style.sliding_arrow(right)
    style.scale_bar(right, style.round_below(0.4 * half_x))
    figure.colorbar(ScalarMappable(norm, style.DEPTH_COLOURS), ax=right, label="worn depth [µm]", shrink=0.8, pad=0.02)
    return figure


def show(
    results: Sequence[RunResult],
    folder: Path,
    *,
    ending: str = "png",
    moving: bool = False,
    drawn: Callable[[Sequence[RunResult]], Mapping[str, Callable[[], Figure]]] | None = None,
) -> list[Path]:
    """Write all pictures of results to a folder and return their paths; none if nothing is logged yet.

    ending: png, svg or pdf. moving: draw also loop and scar of each run over the cycles as an animated GIF. drawn: from
    results to functions that draw pictures by name; by default those of contacts at a point. What an unfinished run has
    not logged yet is left out. Raises ResultError if a picture cannot be written.
    """
    if drawn is None or moving:
        results = tuple(result.with_maps() for result in results)
    if not (pictures := (drawn or drawings)(results)):
        return []
    with writing(ResultError, f"cannot write pictures to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=folder):
            pass
    written = [style.save(draw, folder / f"{name}.{ending}") for name, draw in pictures.items()]
    if moving:
        for result in results:
            suffix = f"_{_file_name(result.variant)}" if len(results) > 1 else ""
            written.append(animation(result, folder / f"loop_and_scar{suffix}.gif"))
    return written


def drawings(results: Sequence[RunResult]) -> dict[str, Callable[[], Figure]]:
    """Functions that draw each picture these results allow, by file name without ending; empty if nothing is logged."""
    found: dict[str, Callable[[], Figure]] = {}
    if with_loops := [result for result in results if result.loops]:
        found["loops"] = partial(loops_by_run, with_loops)
    if with_cycles := [result for result in results if result.evolution["cycle"].size]:
        found["evolution"] = partial(evolution_panels, with_cycles)
    if with_scars := [result for result in results if result.scar_cycles()]:
        found["scars_from_above"] = partial(scars_from_above, with_scars)
        for result in with_scars:
            suffix = f"_{_file_name(result.label)}" if len(results) > 1 else ""
            found[f"contact{suffix}"] = partial(contact_maps, result, chosen_cycles(result.scar_cycles(), 4))
            if len(cycles := chosen_cycles(result.scar_cycles(), 5)) > 1:
                found[f"scar_series{suffix}"] = partial(scar_series, result, cycles)
        found["sections"] = partial(scar_sections, with_scars, section_cycles(with_scars))
        # The last, because it alone needs a working OpenGL.
        found["scars_3d"] = partial(scars_in_3d, with_scars)
    return found


def section_cycles(results: Sequence[RunResult]) -> tuple[int, ...]:
    """Cycles whose sections are shown: the last one with scars of all runs, and the first with at least a quarter of
    its depth.
    If no cycle has scars of all runs, the earliest of the runs' last ones.
    """
    shared = sorted(set.intersection(*(set(result.scar_cycles()) for result in results)))
    if not shared:
        return (min(result.scar_cycles()[-1] for result in results),)

    def depth_um(cycle: int) -> float:
        return min(result.scar(cycle, result.bodies[1]).max_depth_um for result in results)

    # Wear is well seen beside other wear from this share of its depth on.
    seen = next(cycle for cycle in shared if depth_um(cycle) >= 0.25 * depth_um(shared[-1]))
    return tuple(sorted({seen, shared[-1]}))


def _file_name(variant: str) -> str:
    return re.sub(r"[^\w.-]+", "_", variant)
