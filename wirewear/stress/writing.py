"""Fields of a cycle as files (a VTU per body and position, a PVD over them, pictures), strengths as table and maps.

A position is a recorded moment of a cycle, given by its name in POSITIONS or its index.
"""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from rich import box
from rich.table import Table

from wirewear.base.errors import ResultError
from wirewear.base.writing import write_csv, write_grid, writing
from wirewear.pictures.style import INK, WIDTH_in, cycle_name, new_figure, panel_letters, save
from wirewear.results import RunResult
from wirewear.results.export import write_collection
from wirewear.stress.bodies import (
    BodyState,
    Tracked,
    body_grid,
    body_states,
    fanned,
    integration_point_cloud,
    plane_section,
    section,
    untracked,
)
from wirewear.stress.pictures import STRESS_COLOURS
from wirewear.stress.state import one_thread
from wirewear.stress.strength import Strength

_MAPS = {
    "largest_von_mises_MPa": "largest von Mises stress",
    "smith_watson_topper_MPa": "Smith–Watson–Topper",
    "crossland_MPa": "Crossland",
}

#: What surrounds the panels of strengths, in inches: left of all, right of each, above all, below each, bars below all.
_LEFT_in, _BESIDE_in, _ABOVE_in, _UNDER_in, _BAR_in, _FOOT_in = 0.75, 0.5, 0.55, 0.6, 0.08, 0.5
_LEVELS = 11


@one_thread()
def write_fields(
    result: RunResult,
    folder: Path,
    *,
    cycle: float,
    at: Sequence[str | int] | None = ("mid-forward",),
    bodies: Sequence[str] = (),
    worn: bool = True,
    integration_points: bool = False,
    pictures: bool = True,
    animation: bool = False,
    tracked: Tracked = untracked,
) -> list[Path]:
    """Write `<body>_<cycle>_<position>.vtu`, `cycle_<cycle>.pvd` over them, and pictures of each position; return all
    files.

    cycle: the cycle recorded nearest to it is taken. at: positions, None for all. bodies: their names, all if empty.
    worn: nodes stand in the worn surface, else where they were when fresh. integration_points: also as clouds of
    points, `<body>_<cycle>_<position>_points.vtp`. animation: also a GIF over the positions. tracked: shows how far
    bodies, files and pictures are. The time of the PVD file is the share of the cycle passed. Where the bodies are
    apart, nothing is drawn.

    Raises ResultError if nothing is recorded there, or the folder cannot be written; GeometryError if wear distorts a
    mesh too much.
    """
    from wirewear.stress.pictures import animate_cycle

    by_body = [body_states(result, one, cycle, at, worn=worn) for one in tracked(bodies or result.bodies, "solving")]
    moments = list(zip(*by_body, strict=True))
    logged = moments[0][0].forces.cycle
    written = []
    with writing(ResultError, f"cannot write fields to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        for states in tracked(moments, "writing"):
            for state in states:
                written.append(write_grid(folder / f"{_name(state)}.vtu", body_grid(state)))
                if integration_points:
                    points = integration_point_cloud(state)
                    written.append(write_grid(folder / f"{_name(state)}_points.vtp", points))
        shown = ((state, str(part)) for states in moments for part, state in enumerate(states))
        of_cycle = [(f"{one.forces.phase[one.position]:.9g}", part, f"{_name(one)}.vtu") for one, part in shown]
        written.append(write_collection(folder / f"cycle_{logged:07d}.pvd", of_cycle))
    touching = [states for states in moments if any(state.applied.any() for state in states)]
    if pictures:
        for states in tracked(touching, "drawing"):
            written.extend(_draw(folder, states))
    if animation and touching:
        written.append(animate_cycle(touching, folder / f"cycle_{logged:07d}.gif", tracked))
    return written


def _name(state: BodyState) -> str:
    return f"{state.forces.body}_{state.forces.cycle:07d}_{state.position:03d}"


def _draw(folder: Path, states: Sequence[BodyState]) -> list[Path]:
    from wirewear.stress.pictures import draw_cut, draw_section, draw_tractions

    place = f"{states[0].forces.cycle:07d}_{states[0].position:03d}"
    return [
        save(lambda: draw_section(states), folder / f"section_{place}.png"),
        save(lambda: draw_cut(states), folder / f"cut_{place}.png"),
        save(lambda: draw_tractions(states), folder / f"tractions_{place}.png"),
    ]


def strength_table(strengths: Sequence[Strength]) -> Table:
    """A table for rich to print, with one line for each strength, a cycle of a body."""
    table = Table(box=box.SIMPLE, pad_edge=False)
    for heading in (
        "cycle",
        "body",
        "von Mises [MPa]",
        "depth [µm]",
        "yields",
        "SWT [MPa]",
        "depth",
        "Crossland [MPa]",
        "depth",
    ):
        table.add_column(heading, justify="left" if heading in ("body", "yields") else "right")
    for one in strengths:
        table.add_row(
            cycle_name(one.cycle),
            one.name,
            f"{one.von_mises.value_MPa:.0f}{', if elastic' if one.yields else ''}",
            f"{one.von_mises.depth_um:.1f}",
            {None: "", True: "yes", False: "no"}[one.yields],
            f"{one.critical_plane.value_MPa:.2f}",
            f"{one.critical_plane.depth_um:.1f}",
            f"{one.crossland.value_MPa:.0f}",
            f"{one.crossland.depth_um:.1f}",
        )
    return table


def write_strength(one: Strength, folder: Path) -> Path:
    """Write a VTU file with the fields of a strength; return its path. Raises ResultError if it cannot be written."""
    with writing(ResultError, f"cannot write strengths to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        return write_grid(_path(one, folder), one.grid)


def save_strength(one: Strength, folder: Path) -> Path:
    """Draw the maps of a strength beside its VTU file; return the picture's path. Raises ResultError if it cannot be
    written.
    """
    with writing(ResultError, f"cannot write strengths to {folder}"):
        return save(partial(draw_strength, one), _path(one, folder).with_suffix(".png"))


def _path(one: Strength, folder: Path) -> Path:
    return folder / f"strength_{one.name}_{one.cycle:07d}.vtu"


def write_strength_table(strengths: Sequence[Strength], folder: Path) -> Path:
    """Write strength.csv with a row for each strength; return its path. Raises ResultError if that fails."""
    with writing(ResultError, f"cannot write strengths to {folder}"):
        return write_csv(folder / "strength.csv", [_row(one) for one in strengths])


def draw_strength(strength: Strength) -> Figure:
    """Picture of von Mises, Smith–Watson–Topper and Crossland stress from above, on the surface, and below it in the
    section along the motion; a line contact's below only.
    """
    above = len(strength.surface) > 0
    points = np.asarray(strength.grid.points)[strength.nodes]
    low, high = points.min(axis=0), points.max(axis=0)
    wide, across, deep = high - low
    figure, panels, bars = _panels(float(wide), [float(across), float(deep)] if above else [float(deep)])
    for column, bar, (name, title) in zip(panels.T, bars, _MAPS.items(), strict=True):
        values = np.asarray(strength.grid.point_data[name])
        levels = np.linspace(0.0, float(values.max()) or 1.0, _LEVELS)
        if above:
            surface = fanned(np.asarray(strength.grid.points)[:, :2], values, strength.surface)
            column[0].tricontourf(surface.places, surface.values, levels=levels, cmap=STRESS_COLOURS)
            column[0].set_ylim(low[1], high[1])
        # The section at the middle y; of a line contact the plane that it is, where there are nodes.
        if len(strength.surface):
            cut = section(strength.grid, 1, float(0.5 * (low[1] + high[1])), name)
        else:
            cut = plane_section(strength.grid, name, within=strength.nodes)
        column[-1].tricontourf(
            cut.places, np.clip(cut.values, 0.0, 0.9999 * levels[-1]), levels=levels, cmap=STRESS_COLOURS
        )
        column[-1].set(ylim=(low[2], high[2]), xlabel="x, along the motion [µm]")
        column[0].set_title(title)
        for axes in column:
            axes.set_xlim(low[0], high[0])
            axes.grid(visible=False)
        colours = ScalarMappable(Normalize(0.0, levels[-1]), STRESS_COLOURS)
        figure.colorbar(colours, cax=bar, label="MPa", orientation="horizontal")
    if above:
        panels[0][0].set_ylabel("on the surface: y [µm]")
    panels[-1][0].set_ylabel("beneath it: z [µm]" if above else "z [µm]")
    panel_letters(list(panels.ravel()))
    length = strength.asked.averaging_length_um
    averaged = f"averaged over {length:g} µm" if length > 0.0 else "not averaged"
    bulk = ", with the bulk stress" if "bulk_stress_MPa" in strength.grid.field_data else ""
    title = f"{strength.body}, cycle {cycle_name(strength.cycle)}, stresses {averaged}{bulk}"
    figure.suptitle(title, fontsize=9, color=INK)
    return figure


def _panels(wide_um: float, tall_um: Sequence[float]) -> tuple[Figure, Any, list[Axes]]:
    """A figure with rows of panels for all maps that show so much at one scale, (rows, maps), and a bar below each map.

    Their places are fixed: to search for a layout takes several times as long as to draw it.
    """
    column = (WIDTH_in - _LEFT_in) / len(_MAPS)
    scale = min((column - _BESIDE_in) / wide_um, 3.0 / max(tall_um))
    height = _ABOVE_in + sum(scale * tall + _UNDER_in for tall in tall_um) + _BAR_in + _FOOT_in
    figure = new_figure(height, arranged=False)

    def row(bottom_in: float, tall_in: float) -> list[Axes]:
        lefts = [_LEFT_in + column * k for k in range(len(_MAPS))]
        size = scale * wide_um / WIDTH_in, tall_in / height
        return [figure.add_axes((left / WIDTH_in, bottom_in / height, *size)) for left in lefts]

    panels, top = [], height - _ABOVE_in
    for tall in tall_um:
        panels.append(row(top - scale * tall, scale * tall))
        top -= scale * tall + _UNDER_in
    return figure, np.array(panels), row(_FOOT_in, _BAR_in)


def _row(one: Strength) -> dict[str, float | int | str | bool | None]:
    row: dict[str, float | int | str | bool | None] = {
        "cycle": one.cycle,
        "wire": one.name,
        "averaging_length_um": one.asked.averaging_length_um,
        "yield_strength_MPa": one.asked.yield_strength_MPa,
        "yields": one.yields,
        "crossland_slope": one.asked.crossland_slope,
    }
    for name, where in (
        ("von_mises", one.von_mises),
        ("smith_watson_topper", one.critical_plane),
        ("crossland", one.crossland),
        ("swing", one.swing),
    ):
        row |= {
            f"{name}_MPa": where.value_MPa,
            f"{name}_x_um": where.x_um,
            f"{name}_y_um": where.y_um,
            f"{name}_depth_um": where.depth_um,
        }
    return row
