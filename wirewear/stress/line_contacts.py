"""Stresses inside the bodies of a line contact, in plane strain: solved again from a result, written and drawn."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import lru_cache
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from geometry import PlanarGeometry, PlanarMesh, RingGeometry, build_planar
from geometry.arrays import IntArray
from solvers.stress.line_surface_stress import LineSurfaceStress
from wirewear.base.errors import ResultError
from wirewear.base.writing import write_grid, writing
from wirewear.pictures.style import INK, cycle_name, new_figure, panel_letters, save
from wirewear.results import ContactForces, RunResult
from wirewear.simulation import line_plan
from wirewear.stress.bodies import Tracked, plane_section, stressed_grid, untracked
from wirewear.stress.pictures import STRESS_COLOURS
from wirewear.stress.state import InnerState, Inside, SolvedBody, one_thread
from wirewear.test import LineStudy, study_from_tables

if TYPE_CHECKING:
    import pyvista

_LEVELS = 11


class LineBody(SolvedBody[PlanarMesh]):
    """Pad or specimen of a line contact with its factorised stiffness; mesh and patch have points (n, 2), x and z."""

    corrected = LineSurfaceStress
    plane = True

    @property
    def outer_faces(self) -> IntArray:
        """Empty (0, 4): a planar body's surface is a line without faces."""
        return np.zeros((0, 4), dtype=np.int64)


def _worn(result: RunResult, forces: ContactForces, worn: bool) -> LineBody:
    depth = np.maximum(1e-3 * result.scar(forces.cycle, forces.body).depth_um, 0.0).tobytes() if worn else b""
    return _meshed(_tables(result), result.fidelity, forces.body, depth)


def _least_extent_mm(result: RunResult, forces: ContactForces) -> float:
    geometry = _geometry(_study(_tables(result)), result.fidelity, forces.body)
    return min(2.0 * geometry.half_width_mm, geometry.height_mm)


@lru_cache(maxsize=2)
def _meshed(tables: str, fidelity: str, body: str, depth: bytes) -> LineBody:
    """A body meshed as in the run, worn by a depth (n,) in mm or, of no length, fresh, with its factors."""
    study = _study(tables)
    meshed = build_planar(_geometry(study, fidelity, body))
    if depth:
        meshed = meshed.worn(np.frombuffer(depth))
    return LineBody.of(meshed, (study.pad if body == "pad" else study.specimen).elastic)


def _tables(result: RunResult) -> str:
    # A millimetre of a shaft is no study.
    radius = result.study["specimen"].get("shaft_radius_mm")
    whole = result if radius is None else result.of_length(2.0 * pi * radius)
    return json.dumps(whole.study, sort_keys=True, default=str)


def _study(tables: str) -> LineStudy:
    study: LineStudy = study_from_tables(json.loads(tables), "the result")
    return study


def _geometry(study: LineStudy, fidelity: str, body: str) -> PlanarGeometry | RingGeometry:
    meshes = line_plan(study, fidelity)
    return meshes.pad if body == "pad" else meshes.specimen


def state_grid(state: InnerState[LineBody]) -> pyvista.UnstructuredGrid:
    """A body's quadrilaterals at y = 0, in µm, in the test's axes, with the fields of `stressed_grid`."""
    import pyvista

    return stressed_grid(state, pyvista.CellType.QUAD)


INSIDE_LINES = Inside(InnerState[LineBody], _worn, _least_extent_mm, state_grid)


@one_thread()
def write_line_fields(
    result: RunResult,
    folder: Path,
    *,
    cycle: float,
    at: Sequence[str | int] | None,
    bodies: Sequence[str] = (),
    worn: bool = True,
    tracked: Tracked = untracked,
    **_shown: Any,
) -> list[Path]:
    """Write `<body>_<cycle>_<position>.vtu` and `section_<cycle>_<position>.png` of positions of a cycle; return all
    files.

    cycle, at, bodies, worn: as in `stress.writing.write_fields`. tracked: shows how far the positions are. Where the
    bodies are apart, nothing is drawn. Raises ResultError if nothing is recorded there, or the folder cannot be
    written; GeometryError if wear distorts a mesh too much.
    """
    bodies = bodies or result.bodies
    recorded = result.forces(cycle, bodies[-1])
    written = []
    for one in tracked(range(len(recorded.phase)) if at is None else at, "solving and writing"):
        k = recorded.position(one)
        states = {body: INSIDE_LINES.states(result, body, cycle, [k], worn=worn)[0] for body in bodies}
        grids = {body: state_grid(state) for body, state in states.items()}
        with writing(ResultError, f"cannot write fields to {folder}"):
            folder.mkdir(parents=True, exist_ok=True)
            for body, grid in grids.items():
                written.append(write_grid(folder / f"{body}_{recorded.cycle:07d}_{k:03d}.vtu", grid))
        if any(grid.cell_data["von_mises_MPa"].any() for grid in grids.values()):
            written.append(_drawn(states[bodies[-1]], grids, folder / f"section_{recorded.cycle:07d}_{k:03d}.png"))
    return written


def _drawn(state: InnerState[LineBody], grids: Mapping[str, pyvista.UnstructuredGrid], path: Path) -> Path:
    forces = state.forces
    # The recorded forces reach as far as the contact ever does.
    reach = 1e3 * float(np.abs(state.body.patch.axial_mm[forces.nodes]).max())
    title = f"cycle {cycle_name(forces.cycle)}, drive {forces.drive_um[state.position]:.1f} µm"
    return save(lambda: _section(list(grids.values()), 2.5 * reach, title), path)


def _section(grids: Sequence[pyvista.UnstructuredGrid], half_um: float, title: str) -> Figure:
    """The bodies whole, and near the contact; of a contact as wide as these, where the stress is largest."""
    largest = max(float(grid.cell_data["von_mises_MPa"].max()) for grid in grids)
    levels = np.linspace(0.0, largest, _LEVELS)
    figure = new_figure(3.2)
    everything = np.vstack([grid.points for grid in grids])
    whole = 0.52 * float(np.ptp(everything[:, [0, 2]], axis=0).max())
    middle = 0.5 * (everything[:, 2].max() + everything[:, 2].min())
    views = [(whole, "both bodies" if len(grids) > 1 else "the whole body", (0.0, middle))]
    if half_um < whole:
        views.append((half_um, "near the contact", (0.0, 0.0)))
    else:
        worst = max(grids, key=lambda grid: float(grid.cell_data["von_mises_MPa"].max()))
        place = worst.cell_centers().points[worst.cell_data["von_mises_MPa"].argmax()]
        views.append((0.1 * whole, "where it is largest", (float(place[0]), float(place[2]))))
    panels = figure.subplots(1, 2)
    for axes, (half, name, (x, z)) in zip(panels, views, strict=True):
        for grid in grids:
            cut = plane_section(grid)
            values = np.clip(cut.values, 0.0, 0.9999 * largest)
            axes.tricontourf(cut.places, values, levels=levels, cmap=STRESS_COLOURS)
            axes.tricontour(cut.places, cut.values, levels=levels[1:], colors=INK, linewidths=0.3)
        axes.set(
            aspect="equal",
            xlim=(x - half, x + half),
            ylim=(z - half, z + half),
            xlabel="x, along the motion [µm]",
            title=name,
        )
        axes.grid(visible=False)
        axes.locator_params(nbins=5)
    panels[0].set_ylabel("z [µm]")
    panel_letters(list(panels))
    colours = ScalarMappable(Normalize(0.0, largest), STRESS_COLOURS)
    figure.colorbar(colours, ax=panels, label="von Mises stress [MPa]", pad=0.01)
    figure.suptitle(title, fontsize=9)
    return figure
