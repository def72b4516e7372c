"""Contacts of a strand or rope as a cross-section, a table and a page.

Members are the wires or strands of a layer. Rows are those of the rope's contacts, the worst first.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from math import cos, degrees, inf, isnan, pi, sin
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Ellipse

from wirewear.base import frame
from wirewear.base.errors import ResultError
from wirewear.base.frame import figure as written
from wirewear.base.units import unit_of, words_of
from wirewear.base.words import counted
from wirewear.base.writing import json_text, write_csv, write_text, writing
from wirewear.pictures.style import GREY, INK, VARIANT_COLOURS, new_figure, save, svg
from wirewear.strand.construction import Fibre, RopeWire, Strand

if TYPE_CHECKING:
    from rich.table import Table

    from wirewear.strand import RopeContacts

PAGE, TABLE, PICTURE = "strand.html", "contacts.csv", "section.png"
_PAGE = Path(__file__).parent / "strand.html"
_MARKS = ("o", "s", "D", "^", "v", "P", "X", "*")
_METAL, _FIBRE = "#e4e6e8", "#f1ead9"

#: Columns that are printed, with what stands above them.
_PRINTED = {
    "angle_deg": "angle [°]",
    "normal_load_N": "load [N, N/mm]",
    "peak_pressure_MPa": "p0 [MPa]",
    "slip_amplitude_um": "slip [µm]",
    "force_ratio": "Q/µP",
    "regime": "regime",
    "mean_stress_MPa": "mean stress [MPa]",
    "stress_amplitude_MPa": "swing ± [MPa]",
    "worn_volume_per_cycle_mm3": "wear a cycle [mm³, mm²]",
    "worn_depth_um": "worn depth [µm]",
    "life_cycles": "life [cycles]",
}

#: Figures of the whole rope: their words and units.
_FIGURES = {
    "diameter_mm": ("diameter", "mm"),
    "axial_stiffness_N": ("axial stiffness EA, rotation held", "N"),
    "least_bending_stiffness_N_mm2": ("bending stiffness EI, all wires slip", "N·mm²"),
    "largest_bending_stiffness_N_mm2": ("bending stiffness EI, all wires stick", "N·mm²"),
    "torque_N_mm": ("torque that holds the rotation, right lay positive", "N·mm"),
}

Place = tuple[float, float]


def sentence(found: RopeContacts) -> str:
    """Sentences on the rope's load and its worst contact."""
    worst, c = found.contacts[0], found.tables.conditions
    contact, life = worst.contact, worst.life_cycles
    load = f"{written(contact.load_N)} {'N/mm' if contact.is_line else 'N'}, p0 {counted(worst.peak_pressure_MPa)} MPa"
    slip = "" if contact.sort == "sheave" else f", slip ±{1e3 * contact.slip_amplitude_mm:.3g} µm, {worst.regime}"
    ends = "" if isnan(life) else f", {'no crack' if life == inf else f'a crack after some {_cycles(life)} cycles'}"
    kinds = f"{len(found.contacts)} kinds of contact" if len(found.contacts) > 1 else "one kind of contact"
    return (
        f"{kinds[:1].upper()}{kinds[1:]} under {written(c.tension_N)} N and a bending radius of "
        f"{written(c.bending_radius_mm)} mm. The worst: {contact.name}, {load}{slip}{ends}."
    )


def _cycles(life: float) -> str:
    return "∞" if life == inf else counted(float(f"{life:.2g}")) if life < 1e9 else f"{life:.1e}"


def shown_rows(found: RopeContacts, rows: Sequence[Mapping[str, object]]) -> list[dict[str, object]]:
    """The rows of table and page: those given, one for each contact in the order of `found`, with stress amplitude and
    life added.
    """
    made = []
    for one, row in zip(found.contacts, rows, strict=True):
        swing = one.contact.upper.amplitude_MPa
        made.append({**row, "stress_amplitude_MPa": swing, "life_cycles": one.life_cycles})
    return made


def strand_tables(found: RopeContacts, rows: Sequence[Mapping[str, object]]) -> list[Table]:
    """Tables to be printed with rich: estimates of all contacts and, if any were run, the results of the runs."""
    shown = shown_rows(found, rows)
    runs = [row for row in shown if row.get("run_friction_energy_mJ") is not None]
    tables = [_table(shown, _PRINTED)]
    return [*tables, _table(runs, _run_headings(runs))] if runs else tables


def _table(rows: Sequence[Mapping[str, Any]], headings: Mapping[str, str]) -> Table:
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("contact", no_wrap=True)
    for key, heading in headings.items():
        width = 10 if key in ("worn_volume_per_cycle_mm3", "life_cycles") else None
        table.add_column(escape(heading), justify="right", no_wrap=key == "regime", min_width=width)
    for row in rows:
        table.add_row(row["contact"], *(_text(key, row[key]) for key in headings))
    return table


def _run_headings(rows: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """Headings of the columns of runs, by column; empty if nothing was run."""
    runs = [key for key in rows[0] if key.startswith("run_") and key != "run_failure"]
    return {key: f"{words_of(key)} [{unit_of(key)}]" for key in runs}


def _text(key: str, value: Any) -> str:
    if isinstance(value, str):
        return value
    is_life = key.endswith("life_cycles") and value is not None and not isnan(value)
    return _cycles(value) if is_life else written(value)


def strand_json(found: RopeContacts, rows: Sequence[Mapping[str, object]]) -> str:
    """JSON of the rope's figures and the given rows, one for each contact; infinite or unknown values are null."""
    return json_text({"name": found.name, **found.figures, "contacts": list(rows), "notes": found.notes})


def write_strand(found: RopeContacts, rows: Sequence[Mapping[str, object]], folder: Path) -> list[Path]:
    """Write contacts.csv, section.png and strand.html, and return their paths. Raises ResultError if the folder cannot
    be written to.
    """
    with writing(ResultError, f"cannot write to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        return [
            write_csv(folder / TABLE, rows),
            save(partial(draw_section, found), folder / PICTURE),
            write_text(folder / PAGE, page(found, rows)),
        ]


def page(found: RopeContacts, rows: Sequence[Mapping[str, object]]) -> str:
    """Self-contained HTML page of a rope's contacts; rows: one for each contact in the order of `found`."""
    headings, shown = _PRINTED | _run_headings(rows), shown_rows(found, rows)
    values = {
        "name": found.name,
        "summary": sentence(found),
        "picture": frame.inline_svg(svg(partial(draw_section, found)), "section"),
        "headings": list(headings.values()),
        "table": [[row["contact"], *(_text(key, row[key]) for key in headings)] for row in shown],
        "notes": found.notes,
        "figures": [
            (_FIGURES[key][0], f"{written(value, 4)} {_FIGURES[key][1]}") for key, value in found.figures.items()
        ],
        "failures": [(row["contact"], row["run_failure"]) for row in rows if row.get("run_failure")],
        "mood": "open" if any(one.yield_ratio > 1.0 for one in found.contacts) else "good",
    }
    return frame.rendered(_PAGE, values)


def draw_section(found: RopeContacts) -> Figure:
    """Figure of the cross-section with the places of each kind of contact; the legend lists the worst first."""
    figure = new_figure(4.6)
    axes, legend = figure.subplots(1, 2, width_ratios=(1.25, 1.0))
    reach = 0.5 * found.rope.diameter_mm
    _draw_strand(axes, found.rope, (0.0, 0.0), 0.0)
    places = dict(_places(found.rope))
    size = 55.0 / max(len(next(iter(places.values()), ())) ** 0.5, 1.0)
    for rank, one in enumerate(found.contacts):
        name = one.contact.name
        at = np.array(places.get(name, ())).reshape(-1, 2)
        colour, mark = VARIANT_COLOURS[rank % len(VARIANT_COLOURS)], _MARKS[rank % len(_MARKS)]
        axes.scatter(*at.T, s=size, color=colour, marker=mark, edgecolor=INK, linewidth=0.4, zorder=4)
        life = one.life_cycles
        text = f"{rank + 1}  {name}\n     p0 {one.peak_pressure_MPa:.0f} MPa"
        text += f", ±{1e3 * one.contact.slip_amplitude_mm:.3g} µm" if one.contact.sort != "sheave" else ""
        text += "" if isnan(life) else f", {_cycles(life)} cycles"
        legend.scatter([], [], s=40, color=colour, marker=mark, edgecolor=INK, linewidth=0.4, label=text)
    axes.set(
        aspect="equal", xlim=(-1.08 * reach, 1.08 * reach), ylim=(-1.08 * reach, 1.08 * reach), xlabel="mm", ylabel="mm"
    )
    axes.grid(visible=False)
    legend.axis("off")
    legend.legend(loc="center left", frameon=False, fontsize=7.5, labelspacing=1.1, title="the worst first")
    return figure


def _draw_strand(axes: Axes, strand: Strand, centre: Place, turned: float) -> None:
    for member, at, angle, slope in _members(strand, centre, turned):
        if isinstance(member, Strand):
            axes.add_patch(
                Circle(at, 0.5 * member.diameter_mm, fill=False, edgecolor=GREY, linewidth=0.5, linestyle=":")
            )
            _draw_strand(axes, member, at, angle if member is strand.core else angle + 0.5 * pi)
            continue
        d = member.diameter_mm
        colour = _FIBRE if isinstance(member, Fibre) else _METAL
        # A section across the axis cuts a helix obliquely.
        axes.add_patch(
            Ellipse(at, d, d / slope, angle=degrees(angle), facecolor=colour, edgecolor=INK, linewidth=0.6, zorder=2)
        )


def _members(
    strand: Strand, centre: Place, turned: float
) -> Iterator[tuple[RopeWire | Fibre | Strand, Place, float, float]]:
    """Core and members of a strand: body, centre in the section, angle about the axis, cosine of the lay angle."""
    yield strand.core, centre, turned, 1.0
    for place, layer in enumerate(strand.layers):
        for angle in _angles(strand, place, turned):
            yield layer.member, _at(centre, layer.helix.radius_mm, angle), angle, cos(layer.helix.angle_rad)


def _angles(strand: Strand, place: int, turned: float) -> list[float]:
    """Angles in rad of a layer's members about the axis; in the valleys of the layer below, or starting at the top."""
    layer = strand.layers[place]
    if layer.in_valleys:
        return [angle + pi / layer.count for angle in _angles(strand, place - 1, turned)]
    return [turned + 0.5 * pi + 2.0 * pi * k / layer.count for k in range(layer.count)]


def _at(centre: Place, radius: float, angle: float) -> Place:
    return centre[0] + radius * cos(angle), centre[1] + radius * sin(angle)


def _places(rope: Strand) -> Iterator[tuple[str, list[Place]]]:
    """Name of each kind of contact and its points in the section."""
    for prefix, strand, centres in _strands(rope):
        for place, layer in enumerate(strand.layers):
            ring = isinstance(layer.member, Strand)
            own, below = ("outer strands", "core strand") if ring else (f"layer {place + 1}", f"layer {place}")
            if place == 0 and not isinstance(strand.core, Strand):
                below = "core"
            name = f"{own} on {below}" if layer.touches else f"{own} side by side"
            found = [one for at, turned in centres for one in _touching(strand, place, at, turned)]
            yield f"{prefix}{name}", found
            if not prefix and place + 1 == len(strand.layers):
                yield f"{own} on sheave", [(0.0, -layer.helix.radius_mm - 0.5 * layer.member.diameter_mm)]


def _touching(strand: Strand, place: int, centre: Place, turned: float) -> Iterator[Place]:
    """Points where members of a layer touch what lies below, or each other if they arch."""
    layer = strand.layers[place]
    radius, half, step = layer.helix.radius_mm, 0.5 * layer.member.diameter_mm, pi / layer.count
    for angle in _angles(strand, place, turned):
        if not layer.touches:
            yield _at(centre, radius * cos(step), angle + step)
        elif not layer.in_valleys:
            yield _at(centre, radius - half, angle)
        else:
            beneath = strand.layers[place - 1]
            share = half / (half + 0.5 * beneath.member.diameter_mm)
            x, y = _at(centre, radius, angle)
            for side in (-step, step):
                u, v = _at(centre, beneath.helix.radius_mm, angle + side)
                yield x + share * (u - x), y + share * (v - y)


def _strands(rope: Strand) -> Iterator[tuple[str, Strand, list[tuple[Place, float]]]]:
    """Prefix of names, strand, and (centre, angle) of each copy: the rope itself, its core strand and its outer
    strands.
    """
    yield "", rope, [((0.0, 0.0), 0.0)]
    if isinstance(rope.core, Strand):
        yield "core strand: ", rope.core, [((0.0, 0.0), 0.0)]
    for place, layer in enumerate(rope.layers):
        if isinstance(layer.member, Strand):
            # Each turns a wire to what it lies on.
            centres = [
                (_at((0.0, 0.0), layer.helix.radius_mm, one), one + 0.5 * pi) for one in _angles(rope, place, 0.0)
            ]
            yield "outer strands: ", layer.member, centres
