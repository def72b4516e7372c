"""The first loop of an import, in numbers and as a picture, before anything is written."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np
from matplotlib.figure import Figure

from wirewear.base.writing import prepared_folder
from wirewear.loops import LoopError
from wirewear.pictures.colours import DEPTH_COLOURS, GREY, VARIANT_COLOURS
from wirewear.pictures.style import WIDTH_in, new_figure, save
from wirewear.records.remarks import listed, plural
from wirewear.records.values import WIRES, ExperimentRecord, MeasuredLoop, MeasuredScar

FEW = 5

#: Scars of one wire, or profiles of one body, that are drawn.
MOST_DRAWN = 3

Measured = TypeVar("Measured")


def first_loop_text(record: ExperimentRecord) -> str:
    """What would be imported, the first samples of the first loop, and its figures."""
    counted_parts = (
        (record.repeats, "repeat"),
        (record.loops, "loop"),
        (record.evolution, "evolution table"),
        (record.scars, "scar map"),
    )
    return "\n".join(
        [
            *parts_lines(record.notes, [(len(items), noun) for items, noun in counted_parts], record.cycles),
            *loop_lines(record.loops[0], record.tables.conditions.normal_load_N),
        ]
    )


def parts_lines(notes: Sequence[str], parts: Sequence[tuple[int, str]], cycles: Sequence[int]) -> list[str]:
    """How much of what would be imported, and which cycles."""
    counts = ", ".join(plural(count, noun) for count, noun in parts)
    return [*(f"note: {note}" for note in notes), f"{counts}; cycles {listed(cycles)}" if cycles else counts]


def loop_lines(loop: MeasuredLoop, normal_load_N: float) -> list[str]:
    """The first samples of a loop, and its figures."""
    lines = [
        f"first loop: {loop.name}, {plural(loop.time_s.size, 'sample')}",
        f"{'time_s':>12} {'displacement_um':>16} {'tangential_force_N':>19} {'normal_force_N':>15}",
    ]
    normal = np.full(loop.time_s.size, np.nan) if loop.normal_force_N is None else loop.normal_force_N
    channels = (loop.time_s, loop.displacement_um, loop.tangential_force_N, normal)
    rows = zip(*(channel[:FEW].tolist() for channel in channels), strict=True)
    lines += [f"{time:12.6g} {x:16.6g} {q:19.6g} {p:15.6g}" for time, x, q, p in rows]
    try:
        figures = loop.figures(normal_load_N)
    except LoopError as problem:
        return [*lines, f"this is no loop that can be analysed: {problem}"]
    lines.append(
        f"δa {figures.displacement_amplitude_um.value:.4g} µm, δ0 {figures.slip_amplitude_um.value:.4g} µm, "
        f"energy {figures.dissipated_energy_mJ.value:.4g} mJ, {figures.regime}"
    )
    return [*lines, *figures.notes]


def draw_first_loop(loop: MeasuredLoop, path: Path) -> Path:
    """Write the picture of the first loop; its folder is made if need be."""
    prepared_folder(path.parent)
    return save(lambda: _picture(loop), path)


def draw_scars(record: ExperimentRecord, output: Path) -> list[Path]:
    """Draw each wire's scars as they would be imported: depth below the fitted cylinder, on one scale."""
    wires = record.tables.wires
    scars = {wire: record.scars_of(wire) for wire in WIRES}
    return draw_each(scars, "scar", lambda own, wire: _scar_picture(own, wire, wires.axis_angle_deg(wire)), output)


def draw_each(
    measured: Mapping[str, Sequence[Measured]],
    what: str,
    picture: Callable[[Sequence[Measured], str], Figure],
    output: Path,
) -> list[Path]:
    """Draw the first of what was measured of each body, beside where the record would be; the pictures' paths."""
    drawn = []
    for body, items in measured.items():
        if items:
            path = output.with_name(f"{output.name}_{what}_{body}.png")
            prepared_folder(path.parent)
            drawn.append(save(partial(picture, items[:MOST_DRAWN], body), path))
    return drawn


def _scar_picture(scars: Sequence[MeasuredScar], wire: str, axis_angle_deg: float) -> Figure:
    # As wide as its panels: one alone would stand aside.
    figure = new_figure(3.4, min(WIDTH_in, 1.5 + 2.4 * len(scars)))
    panels = figure.subplots(1, len(scars), sharex=True, sharey=True, squeeze=False)[0]
    deepest = max([1e-6, *(float(np.nanmax(scar.depth_um)) for scar in scars)])
    for axes, scar in zip(panels, scars, strict=True):
        image = axes.pcolormesh(scar.x_um, scar.y_um, scar.depth_um.T, vmin=0.0, vmax=deepest, cmap=DEPTH_COLOURS)
        axes.set_aspect("equal")
        along = np.radians(axis_angle_deg)
        axes.axline((0.0, 0.0), (np.cos(along), np.sin(along)), color=GREY, linewidth=0.7, linestyle=(0, (8, 2, 1, 2)))
        axes.set_title(f"repeat {scar.repeat}\n{1e6 * scar.volume_mm3:.3g}·10⁻⁶ mm³")
        axes.set_xlabel("x, along the motion [µm]")
    panels[0].set_ylabel(f"{wire} wire (its axis dash-dotted), y [µm]")
    figure.colorbar(image, ax=list(panels), label="worn depth [µm]", shrink=0.8)
    return figure


def _picture(loop: MeasuredLoop) -> Figure:
    figure = new_figure(3.2)
    left, right = figure.subplots(1, 2)
    left.plot(loop.displacement_um, loop.tangential_force_N, color=VARIANT_COLOURS[0], marker=".", markersize=3)
    left.plot(loop.displacement_um[:1], loop.tangential_force_N[:1], color=VARIANT_COLOURS[1], marker="o", markersize=6)
    left.set_xlabel("displacement δ [µm]")
    left.set_ylabel("tangential force Q [N]")
    left.set_title(f"{loop.name} (dot: first sample)")
    right.plot(loop.time_s, loop.displacement_um, color=VARIANT_COLOURS[0])
    right.set_xlabel("time [s]")
    right.set_ylabel("displacement δ [µm]", color=VARIANT_COLOURS[0])
    force = right.twinx()
    force.plot(loop.time_s, loop.tangential_force_N, color=VARIANT_COLOURS[1], linestyle="--", linewidth=1.2)
    force.set_ylabel("tangential force Q [N]", color=VARIANT_COLOURS[1])
    force.spines["right"].set_visible(True)
    force.grid(visible=False)
    for axes in (left, right):
        axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    return figure
