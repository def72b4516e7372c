"""An import of a line contact before anything is written: its first loop and its fitted profiles."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from wirewear.pictures.colours import GREY, VARIANT_COLOURS
from wirewear.pictures.style import new_figure
from wirewear.records.importing.first_loop import draw_each, draw_first_loop, loop_lines, parts_lines
from wirewear.records.importing.line_importing import ImportedLine, LevelledProfile
from wirewear.records.line_values import BODIES


def import_text(imported: ImportedLine) -> str:
    """What would be imported, the first samples of the first loop, and the figures of each profile."""
    record = imported.record
    parts = [
        (len(record.repeats), "repeat"),
        (len(record.loops), "loop"),
        (len(record.evolution), "evolution table"),
        (len(record.profiles), "profile"),
    ]
    lines = parts_lines(record.notes, parts, record.cycles)
    if record.loops:
        lines += loop_lines(record.loops[0], record.tables.conditions.normal_load_N)
    for profile in record.profiles:
        size = f"{profile.smooth_um.max():.3g} µm deep, {profile.width_um:.4g} µm wide, {profile.area_um2:.4g} µm²"
        lines.append(f"{profile.body}, repeat {profile.repeat}: {size}")
    return "\n".join(lines)


def draw_import(imported: ImportedLine, output: Path) -> list[Path]:
    """Draw the first loop and each body's profiles beside where the record would be; the pictures' paths."""
    drawn = []
    if imported.record.loops:
        path = output.with_name(f"{output.name}_first_loop.png")
        drawn.append(draw_first_loop(imported.record.loops[0], path))
    fitted = {body: [one for one in imported.fitted if one.profile.body == body] for body in BODIES}
    return drawn + draw_each(fitted, "profile", _picture, output)


def _picture(profiles: Sequence[LevelledProfile], body: str) -> Figure:
    heights = any(one.face_um is not None for one in profiles)
    figure = new_figure(5.0 if heights else 3.0)
    panels = figure.subplots(2 if heights else 1, len(profiles), sharex="col", sharey="row", squeeze=False)
    for (upper, axes), one in zip(((column[0], column[-1]) for column in panels.T), profiles, strict=True):
        profile, (left, right) = one.profile, one.profile.edges_um
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
