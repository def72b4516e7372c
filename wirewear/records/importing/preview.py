"""Preview of an import in words and pictures."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wirewear.base.writing import prepared_folder
from wirewear.loops import LoopError
from wirewear.pictures.panels import draw_axis
from wirewear.pictures.style import GREY, VARIANT_COLOURS, WIDTH_in, depth_scale, new_figure, save
from wirewear.records.contact_tables import LineRecordTables
from wirewear.records.profiles import MeasuredProfile
from wirewear.records.remarks import listed, plural
from wirewear.records.scars import MeasuredScar
from wirewear.records.surfaces import PROFILES, SCARS
from wirewear.records.tables import PointRecordTables
from wirewear.records.values import AnyRecord, MeasuredLoop
from wirewear.results.scar import called, figure_volume


def import_text(record: AnyRecord) -> str:
    """Text on what would be imported: counts, the first loop with its figures, and sizes of worn surfaces."""
    parts = (
        (record.repeats, "repeat"),
        (record.loops, "loop"),
        (record.evolution, "evolution table"),
        (record.scars, record.tables.worn.noun),
    )
    counts = ", ".join(plural(len(items), noun) for items, noun in parts)
    lines = [f"note: {note}" for note in record.notes]
    lines.append(f"{counts}; cycles {listed(record.cycles)}" if record.cycles else counts)
    if record.loops:
        lines += loop_lines(record.loops[0], record.tables.conditions.normal_load_N)
    return "\n".join([*lines, *(f"{one.body}, repeat {one.repeat}: {one.sizes}" for one in record.scars)])


def loop_lines(loop: MeasuredLoop, normal_load_N: float) -> list[str]:
    """Lines of text with the first samples of a loop and its figures; normal_load_N: stands in for a normal force that
    was not measured.
    """
    lines = [
        f"first loop: {loop.name}, {plural(loop.time_s.size, 'sample')}",
        f"{'time_s':>12} {'displacement_um':>16} {'tangential_force_N':>19} {'normal_force_N':>15}",
    ]
    normal = np.full(loop.time_s.size, np.nan) if loop.normal_force_N is None else loop.normal_force_N
    channels = (loop.time_s, loop.displacement_um, loop.tangential_force_N, normal)
    rows = zip(*(channel[:5].tolist() for channel in channels), strict=True)
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


def draw_import(record: AnyRecord, output: Path) -> list[Path]:
    """Draw the first loop and up to three worn surfaces of each body as they would be imported; return the pictures'
    paths. The pictures' names begin with `output`, whose folder is created if missing.
    """
    prepared_folder(output.parent)
    drawn = []
    if record.loops:
        drawn.append(save(lambda: _picture(record.loops[0]), output.with_name(f"{output.name}_first_loop.png")))
    name = record.tables.worn.name
    for body in record.tables.body_names:
        # Scars of one wire, or profiles of one body, that are drawn.
        if own := record.scars_of(body)[:3]:
            path = output.with_name(f"{output.name}_{name}_{body}.png")
            drawn.append(save(partial(_PICTURES[name], own, body, record.tables), path))
    return drawn


def _scar_picture(scars: Sequence[MeasuredScar], body: str, tables: PointRecordTables) -> Figure:
    """Figure of a body's depth maps on one colour scale."""
    # As wide as its panels: one alone would stand aside.
    figure = new_figure(3.4, min(WIDTH_in, 1.5 + 2.4 * len(scars)))
    panels = figure.subplots(1, len(scars), sharex=True, sharey=True, squeeze=False)[0]
    colours, norm = depth_scale(scar.depth_um for scar in scars)
    for axes, scar in zip(panels, scars, strict=True):
        image = axes.pcolormesh(scar.x_um, scar.y_um, scar.depth_um.T, norm=norm, cmap=colours)
        axes.set_aspect("equal")
        if has_axis := tables.body(body).has_axis:
            draw_axis(axes, tables.body(body).axis_angle_deg)
        axes.set(title=f"repeat {scar.repeat}\n{figure_volume(scar.volume_mm3)}", xlabel="x, along the motion [µm]")
    panels[0].set_ylabel(f"{called(body)}{' (its axis dash-dotted)' if has_axis else ''}, y [µm]")
    figure.colorbar(image, ax=list(panels), label="worn depth, raised if negative [µm]", shrink=0.8)
    return figure


def _profile_picture(profiles: Sequence[MeasuredProfile], body: str, _: LineRecordTables) -> Figure:
    heights = any(one.face_um is not None for one in profiles)
    figure = new_figure(5.0 if heights else 3.0)
    panels = figure.subplots(2 if heights else 1, len(profiles), sharex="col", sharey="row", squeeze=False)
    for (upper, axes), one in zip(((column[0], column[-1]) for column in panels.T), profiles, strict=True):
        profile, (left, right) = one, one.edges_um
        worn = (profile.x_um >= left) & (profile.x_um <= right)
        axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
        axes.plot(profile.x_um, profile.depth_um, color=VARIANT_COLOURS[0], linewidth=0.8)
        axes.fill_between(profile.x_um[worn], profile.depth_um[worn], color=VARIANT_COLOURS[0], alpha=0.25)
        axes.set_xlabel("x, along the motion [µm]")
        upper.set_title(f"{body}, repeat {profile.repeat}\n{profile.area_um2:.4g} µm²")
        if one.height_um is not None and one.face_um is not None:
            upper.plot(profile.x_um, one.height_um, color=VARIANT_COLOURS[0], linewidth=0.8, label="measured")
            fitted = {"color": VARIANT_COLOURS[1], "linestyle": "--", "linewidth": 1.2}
            upper.plot(profile.x_um, one.face_um, **fitted, label="fitted face")
    panels[-1][0].invert_yaxis()
    if heights:
        panels[0][0].set_ylabel("height [µm]")
        panels[0][0].legend(fontsize="small")
    panels[-1][0].set_ylabel("worn depth [µm]")
    return figure


_PICTURES: Mapping[str, Callable[[Any, str, Any], Figure]] = {
    SCARS.name: _scar_picture,
    PROFILES.name: _profile_picture,
}


def _picture(loop: MeasuredLoop) -> Figure:
    figure = new_figure(3.2)
    left, right = figure.subplots(1, 2)
    left.plot(loop.displacement_um, loop.tangential_force_N, color=VARIANT_COLOURS[0], marker=".", markersize=3)
    left.plot(loop.displacement_um[:1], loop.tangential_force_N[:1], color=VARIANT_COLOURS[1], marker="o", markersize=6)
    left.set(xlabel="displacement δ [µm]", ylabel="tangential force Q [N]", title=f"{loop.name} (dot: first sample)")
    mark_motion(left, loop)
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


def mark_motion(axes: Axes, loop: MeasuredLoop) -> None:
    """Draw an arrow into `axes` on the branch where the displacement grows, with a note on the sign of the force there;
    nothing if it grows nowhere.
    """
    x, q = loop.displacement_um, loop.tangential_force_N
    steps = np.nan_to_num(np.gradient(x))
    if not (growing := np.flatnonzero(steps > 0.5 * steps.max(initial=0.0))).size:
        return
    near = growing[np.argmin(np.abs(x[growing] - np.nanmean(x)))]
    arrow = {"arrowstyle": "-|>", "color": VARIANT_COLOURS[1], "linewidth": 2.0, "mutation_scale": 14}
    axes.annotate("", (x[near] + 0.12 * np.ptp(x[np.isfinite(x)]), q[near]), (x[near], q[near]), arrowprops=arrow)
    said = "δ grows at the arrow:\nthere Q must be positive"
    axes.text(0.5, 0.65, said, transform=axes.transAxes, ha="center", va="center", fontsize=7.5)
