"""The meshes of a line contact, written for other programs, and a picture of how its bodies are held and moved."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from geometry import PlanarMesh, build_planar
from wirewear.base.errors import ResultError
from wirewear.base.writing import in_one_step, writing
from wirewear.pictures.boundary_conditions import HeldBody, Supports, draw_boundary_conditions
from wirewear.pictures.style import save
from wirewear.planar.model import plan, require_affordable_meshes
from wirewear.planar.tables import PlanarStudy


def write_planar_meshes(study: PlanarStudy, fidelity: str, folder: Path) -> list[Path]:
    """Mesh both bodies; leave pad.vtu, specimen.vtu and boundary_conditions.png in a folder.

    Raises:
        StudyError: the study cannot be meshed, or asks for more memory than there is.
        GeometryError: the mesh is distorted.  ResultError: the files cannot be written.
    """
    meshes = plan(study, fidelity)
    require_affordable_meshes(study.name, meshes)
    bodies = {"pad": build_planar(meshes.pad), "specimen": build_planar(meshes.specimen)}
    with writing(ResultError, f"cannot write meshes to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        for name, body in bodies.items():
            with in_one_step(folder / f"{name}.vtu") as partial:
                body.mesh.write(partial)
    picture = save(
        lambda: planar_supports(study, bodies["pad"], bodies["specimen"]), folder / "boundary_conditions.png"
    )
    return [*(folder / f"{name}.vtu" for name in bodies), picture]


def planar_supports(study: PlanarStudy, pad: PlanarMesh, specimen: PlanarMesh) -> Figure:
    """Both bodies with what holds and moves them, per mm of thickness."""
    conditions, holder = study.conditions, study.holder
    tangential, rotational = holder.tangential_stiffness_N_per_mm2, holder.rotational_stiffness_N_per_rad
    supports = Supports(
        load=f"{conditions.normal_load_N_per_mm:g} N/mm",
        stroke=f"±{conditions.displacement_amplitude_um:g} µm",
        tangential="" if tangential == "rigid" else f"{tangential:g} N/mm²",
        rotational="" if rotational == "rigid" else f"{rotational:g} N/rad",
        pivot_height=None if rotational == "rigid" else holder.pivot_height_mm,
    )
    view = ("pad on specimen, plane strain", _held(pad, upper=True), _held(specimen, upper=False))
    return draw_boundary_conditions([view], supports, along_motion=[True])


def _held(body: PlanarMesh, *, upper: bool) -> HeldBody:
    points = body.mesh.points * np.array([1.0, -1.0 if upper else 1.0])
    edges = points[body.mesh.boundary_edges()]
    return HeldBody(edges, points[body.mesh.surfaces["grip"]], body.bedding is not None)
