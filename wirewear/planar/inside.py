"""The bodies of a line contact as they were at a recorded cycle, and their states at positions of that cycle."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry import ContactPatch, Elastic, PlanarGeometry, PlanarMesh, QuadMesh, build_planar
from solvers.interior import Interior
from solvers.line_surface_stress import LineSurfaceStress
from solvers.strain import IntegrationPoints, integration_points
from wirewear.interior.state import InnerState
from wirewear.planar.model import plan
from wirewear.planar.reading import planar_study_from_tables
from wirewear.planar.tables import PlanarStudy
from wirewear.results import RunResult

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class PlanarBody:
    """Pad or specimen with its nodes in the worn surface, or where they were when fresh, and its factors."""

    meshed: PlanarMesh
    material: Elastic
    interior: Interior
    points: IntegrationPoints

    @property
    def mesh(self) -> QuadMesh:
        """Its quadrilaterals."""
        return self.meshed.mesh

    @property
    def patch(self) -> ContactPatch:
        """Its contact patch."""
        return self.meshed.patch

    @cached_property
    def surface(self) -> LineSurfaceStress:
        """Its contact surface, for corrections of the stresses at it."""
        return LineSurfaceStress.of(self.meshed, self.material)


def planar_states(
    result: RunResult, body: str, cycle: int, at: Sequence[str | int] | None = None, *, worn: bool = True
) -> tuple[InnerState[PlanarBody], ...]:
    """A body at positions of a recorded cycle, all recorded ones by default.

    worn: the nodes stand in the worn surface; else where they were when fresh.

    Raises:
        ResultError: no contact forces of that body are recorded at that cycle, or there is no such position.
        GeometryError: wear distorts the mesh too much.
    """
    forces = result.forces(cycle, body)
    chosen = list(range(len(forces.phase))) if at is None else [forces.position(one) for one in at]
    depth = b""
    if worn:
        depth = np.maximum(1e-3 * result.scar(forces.cycle, body).depth_um, 0.0).tobytes()
    found = _meshed(_tables(result), result.fidelity, body, depth)
    nodes = found.patch.nodes.ravel()[forces.nodes]
    displacements = found.interior.displacements(nodes, forces.force_N[chosen])
    upper = result.is_upper(body)
    return tuple(InnerState(found, forces, k, moved, upper) for k, moved in zip(chosen, displacements, strict=True))


def run_geometry(result: RunResult, body: str) -> PlanarGeometry:
    """What the mesh of a body was built from in a run."""
    return _geometry(_study(_tables(result)), result.fidelity, body)


@lru_cache(maxsize=2)
def _meshed(tables: str, fidelity: str, body: str, depth: bytes) -> PlanarBody:
    """A body meshed as in the run, worn by a depth (n,) in mm or, of no length, fresh, with its factors."""
    study = _study(tables)
    meshed = build_planar(_geometry(study, fidelity, body))
    if depth:
        meshed = meshed.worn(np.frombuffer(depth))
    material = (study.pad if body == "pad" else study.specimen).elastic
    held: IntArray = meshed.mesh.surface_nodes("grip")
    interior = Interior(meshed.mesh, material, held if meshed.bedding is None else held[:0], meshed.bedding)
    return PlanarBody(meshed, material, interior, integration_points(meshed.mesh))


def _tables(result: RunResult) -> str:
    return json.dumps(result.study, sort_keys=True, default=str)


def _study(tables: str) -> PlanarStudy:
    loaded: dict[str, Any] = json.loads(tables)
    return planar_study_from_tables(loaded, "the result")


def _geometry(study: PlanarStudy, fidelity: str, body: str) -> PlanarGeometry:
    meshes = plan(study, fidelity)
    return meshes.pad if body == "pad" else meshes.specimen
