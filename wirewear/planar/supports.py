"""The meshes of a line contact, written for other programs, and a picture of how its bodies are held and moved."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from geometry import PlanarMesh, build_planar
from wirewear.base.errors import ResultError
from wirewear.base.writing import in_one_step, writing
from wirewear.effects import Effect
from wirewear.pictures.boundary_conditions import HeldBody, Supports, draw_boundary_conditions
from wirewear.pictures.style import save
from wirewear.planar.model import plan, require_affordable_meshes
from wirewear.planar.tables import PlanarStudy

#: By which power of the contact's length a whole contact's number is larger than that of one millimetre, by its unit;
#: of all other units the numbers are the same.
_POWERS = {"N": 1, "N_per_mm": 1, "N_mm_per_rad": 1, "um_per_N": -1, "um_per_N2": -2}


def per_mm(effects: Iterable[Effect[Any]], length_mm: float) -> tuple[Effect[Any], ...]:
    """Effects of a whole contact as a study of one millimetre of it takes them."""
    return tuple(_scaled(effect, length_mm, -1) for effect in effects)


def of_whole_contact(effects: Iterable[Effect[Any]], length_mm: float) -> tuple[Effect[Any], ...]:
    """Effects of a study per mm as those of the whole contact."""
    return tuple(_scaled(effect, length_mm, 1) for effect in effects)


def _scaled(effect: Effect[Any], length_mm: float, sign: int) -> Effect[Any]:
    known = effect.parameters().items()
    powers = {name: sign * _POWERS.get(described.quantity.unit, 0) for name, described in known}
    return replace(
        effect, **{name: getattr(effect, name) * length_mm**power for name, power in powers.items() if power}
    )


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
