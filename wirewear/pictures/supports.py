"""How the bodies of a contact at a point are held and moved: their sections with grips, load, stroke and springs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from geometry import BodyMesh
from wirewear.pictures.boundary_conditions import HeldBody, Supports, draw_boundary_conditions
from wirewear.pictures.mesh import round_facets, upper_position
from wirewear.study import Study

Array = NDArray[np.float64]

#: A section lies so far beside its plane [mm]: mirror planes are full of facets that would be cut twice.
_BESIDE_mm = 1e-6


def supports(study: Study, moving: BodyMesh, fixed: BodyMesh) -> Figure:
    """Both bodies' sections along the motion and across it."""
    angle = np.radians(study.crossing_angle_deg)
    motion = np.radians(study.motion_angle_deg)

    def view(axis: int) -> tuple[HeldBody, HeldBody]:
        upper = _held(fixed, lambda points: upper_position(points, float(angle - motion)), axis)
        return upper, _held(moving, lambda points: _turned(points, float(-motion)), axis)

    views = [("along the motion", *view(1)), ("across the motion", *view(0))]
    return draw_boundary_conditions(views, _supports(study), along_motion=(True, False))


def _supports(study: Study) -> Supports:
    conditions, holder = study.conditions, study.holder
    tangential, rotational = holder.tangential_stiffness_N_per_mm, holder.rotational_stiffness_N_mm_per_rad
    spring = holder.normal_spring_stiffness_N_per_mm
    return Supports(
        load=f"{conditions.normal_load_N:g} N" if conditions.approach_um is None else f"{conditions.approach_um:g} µm",
        stroke=f"±{conditions.displacement_amplitude_um:g} µm",
        tangential="" if tangential == "rigid" else f"{tangential:g} N/mm",
        normal=f"{spring:g} N/mm" if spring > 0.0 else "",
        rotational="" if rotational == "rigid" else f"{rotational:g} N mm/rad",
        pivot_height=None if rotational == "rigid" else holder.pivot_height_mm,
    )


def _held(body: BodyMesh, placed: Callable[[Array], Array], axis: int) -> HeldBody:
    """A body's section, round where it is; `placed` takes its points to where it lies in the test."""

    def cut(facets: NDArray[np.int64]) -> Array:
        points, finer, _ = round_facets(body.mesh.points, facets, body.geometry.round_mm)
        return _cut(placed(points), finer, axis)

    elastic = body.geometry.grip_stiffness_N_per_mm3 is not None
    return HeldBody(cut(body.mesh.boundary_facets()), cut(body.mesh.surfaces["grip"]), elastic)


def _cut(points: Array, facets: NDArray[np.int64], axis: int) -> Array:
    """Lines (k, 2, 2), in the other coordinate and z, along which facets (m, 4) cross a coordinate's zero."""
    import pyvista

    faces = np.column_stack([np.full(len(facets), 4), facets]).ravel()
    normal = np.eye(3)[axis]
    cut = pyvista.PolyData(points, faces).slice(normal=tuple(normal), origin=tuple(_BESIDE_mm * normal))
    if not cut.n_cells:
        return np.zeros((0, 2, 2))
    lines = np.asarray(cut.lines).reshape(-1, 3)[:, 1:]
    return np.asarray(np.asarray(cut.points)[lines][:, :, [1 - axis, 2]])


def _turned(points: Array, angle_rad: float) -> Array:
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    x, y, z = points.T
    return np.column_stack([c * x - s * y, s * x + c * y, z])
