"""Stresses inside the bodies of a line contact, for any recorded cycle and position: meshes, files, pictures.

The nodes stand where they were when fresh: worn depths of line contacts are small beside their bodies.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from geometry import PlanarMesh, build_planar
from solvers.interior import Interior
from solvers.strain import IntegrationPoints, integration_points
from solvers.stress import hydrostatic, principal, turned, von_mises
from wirewear.errors import ResultError
from wirewear.files import in_one_step, writing
from wirewear.interior.pictures import STRESS_COLOURS
from wirewear.pictures.style import INK, cycle_name, new_figure, panel_letters, save
from wirewear.planar.model import plan
from wirewear.planar.reading import planar_study_from_tables
from wirewear.planar.results import BODIES, PlanarForces, PlanarResult
from wirewear.results.contact_forces import position_of

if TYPE_CHECKING:
    import pyvista

_LEVELS = 11


def planar_grid(result: PlanarResult, body: str, cycle: int, at: str | int) -> pyvista.UnstructuredGrid:
    """The pad's or specimen's quadrilaterals at y = 0, in µm, with the same fields as `interior.body_grid` gives.

    Raises:
        ResultError: no contact forces of that body are recorded at that cycle, or there is no such position.
    """
    import pyvista

    forces = _recorded(result, body, cycle)
    k = position_of(at, forces.phase, cycle)
    mesh, interior, points = _held(_tables(result), result.fidelity, body)
    material = interior.material
    nodes = mesh.patch.nodes.ravel()[forces.nodes.astype(int)]
    displacement = interior.displacements(nodes, forces.force_N_per_mm[[k]])[0]
    inside = points.stresses(material, displacement)
    turn = np.diag([1.0, -1.0, -1.0]) if body == "pad" else np.eye(3)
    stress = turned(points.at_nodes(inside), turn)
    values = principal(stress)
    origin = [forces.holder_x_um[k], 0.0, forces.holder_z_um[k]] if body == "pad" else [forces.drive_um[k], 0.0, 0.0]
    flat = mesh.mesh.points
    places = 1e3 * np.column_stack([flat[:, 0], np.zeros(len(flat)), flat[:, 1]]) @ turn.T + origin
    grid = pyvista.UnstructuredGrid({pyvista.CellType.QUAD: mesh.mesh.cells}, places)
    fields = {
        "displacement_um": 1e3 * displacement @ turn.T,
        "stress_MPa": stress,
        "von_mises_MPa": von_mises(stress),
        "tresca_MPa": values[:, 0] - values[:, 2],
        "principal_MPa": values,
        "hydrostatic_MPa": hydrostatic(stress),
    }
    for name, field in fields.items():
        grid.point_data[name] = field
    grid.cell_data["von_mises_MPa"] = von_mises(inside).mean(axis=1)
    grid.cell_data["scaled_jacobian"] = mesh.mesh.scaled_jacobians()
    return grid


def write_planar_fields(
    result: PlanarResult, folder: Path, *, cycle: int, at: Sequence[str | int] | None
) -> list[Path]:
    """Write `<body>_<cycle>_<position>.vtu` and `section_<cycle>_<position>.png` for positions, None for all.

    Raises:
        ResultError: nothing is recorded there, or the folder cannot be written.
    """
    phase = _recorded(result, BODIES[0], cycle).phase
    written = []
    for one in range(len(phase)) if at is None else at:
        k = position_of(one, phase, cycle)
        grids = {body: planar_grid(result, body, cycle, k) for body in BODIES}
        with writing(ResultError, f"cannot write fields to {folder}"):
            folder.mkdir(parents=True, exist_ok=True)
            for body, grid in grids.items():
                written.append(folder / f"{body}_{cycle:07d}_{k:03d}.vtu")
                with in_one_step(written[-1]) as partial:
                    grid.save(partial)
        written.append(_drawn(result, grids, cycle, k, folder / f"section_{cycle:07d}_{k:03d}.png"))
    return written


def _drawn(
    result: PlanarResult, grids: Mapping[str, pyvista.UnstructuredGrid], cycle: int, position: int, path: Path
) -> Path:
    forces = _recorded(result, "pad", cycle)
    # The recorded forces reach as far as the contact ever does.
    patch = _held(_tables(result), result.fidelity, "pad")[0].patch
    reach = 1e3 * float(np.abs(patch.axial_mm[forces.nodes.astype(int)]).max())
    title = f"cycle {cycle_name(cycle)}, drive {forces.drive_um[position]:.1f} µm"
    return save(lambda: _section(list(grids.values()), 2.5 * reach, title), path)


def _section(grids: Sequence[pyvista.UnstructuredGrid], half_um: float, title: str) -> Figure:
    """Both bodies whole, and near the contact."""
    largest = max(float(grid.cell_data["von_mises_MPa"].max()) for grid in grids)
    levels = np.linspace(0.0, largest, _LEVELS)
    figure = new_figure(3.2)
    panels = figure.subplots(1, 2)
    everything = np.vstack([grid.points for grid in grids])
    whole = 0.52 * float(np.ptp(everything[:, [0, 2]], axis=0).max())
    for axes, half, name in zip(panels, (whole, half_um), ("both bodies", "near the contact"), strict=True):
        for grid in grids:
            quads = np.asarray(grid.cells).reshape(-1, 5)[:, 1:]
            triangles = np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
            places = Triangulation(grid.points[:, 0], grid.points[:, 2], triangles)
            values = np.asarray(grid.point_data["von_mises_MPa"])
            axes.tricontourf(places, np.clip(values, 0.0, 0.9999 * largest), levels=levels, cmap=STRESS_COLOURS)
            axes.tricontour(places, values, levels=levels[1:], colors=INK, linewidths=0.3)
        centre = 0.5 * (everything[:, 2].max() + everything[:, 2].min()) if half == whole else 0.0
        axes.set_aspect("equal")
        axes.set_xlim(-half, half)
        axes.set_ylim(centre - half, centre + half)
        axes.set_xlabel("x, along the motion [µm]")
        axes.set_title(name)
        axes.grid(visible=False)
    panels[0].set_ylabel("z [µm]")
    panel_letters(list(panels))
    colours = ScalarMappable(Normalize(0.0, largest), STRESS_COLOURS)
    figure.colorbar(colours, ax=panels, label="von Mises stress [MPa]", pad=0.01)
    figure.suptitle(title, fontsize=9)
    return figure


def _recorded(result: PlanarResult, body: str, cycle: int) -> PlanarForces:
    for forces in result.forces:
        if (forces.cycle, forces.body) == (cycle, body):
            return forces
    logged = ", ".join(str(c) for c in sorted({forces.cycle for forces in result.forces})) or "none"
    raise ResultError(f"no contact forces of the {body} are recorded at cycle {cycle}; recorded cycles are: {logged}")


def _tables(result: PlanarResult) -> str:
    import json

    return json.dumps(result.study, sort_keys=True, default=str)


@lru_cache(maxsize=2)
def _held(tables: str, fidelity: str, body: str) -> tuple[PlanarMesh, Interior, IntegrationPoints]:
    """A body meshed as in the run, with its factors."""
    import json

    loaded: dict[str, Any] = json.loads(tables)
    study = planar_study_from_tables(loaded, "the result")
    meshes = plan(study, fidelity)
    pad = body == "pad"
    meshed = build_planar(meshes.pad if pad else meshes.specimen)
    material = (study.pad if pad else study.specimen).elastic
    held = meshed.mesh.surface_nodes("grip")
    return meshed, Interior(meshed.mesh, material, held), integration_points(meshed.mesh)
