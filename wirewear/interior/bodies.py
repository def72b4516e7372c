"""A wire of a finished run as it was at a recorded cycle, and its state at positions of that cycle."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from geometry import BodyGeometry, BodyMesh, ContactPatch, Elastic, GeometryError, HexMesh, build_body
from geometry.arrays import Array
from solvers.interior import Interior
from solvers.strain import IntegrationPoints, integration_points
from solvers.surface_stress import SurfaceStress
from wirewear.interior.state import InnerState
from wirewear.results import RunResult

#: Layers under the patch over those of the run. Its pressures need no more, but stresses two or three half-widths deep.
_DEEPER = 1.4


@dataclass(frozen=True, eq=False)
class WornBody:
    """A wire with its nodes in the worn surface, or where they were when fresh, and its factors."""

    wire: BodyMesh
    material: Elastic
    interior: Interior
    points: IntegrationPoints

    @property
    def mesh(self) -> HexMesh:
        """Its hexahedra."""
        return self.wire.mesh

    @property
    def patch(self) -> ContactPatch:
        """Its contact patch."""
        return self.wire.patch

    @cached_property
    def surface(self) -> SurfaceStress:
        """Its contact surface, for corrections of the stresses at it."""
        return SurfaceStress.of(self.wire, self.material)


@dataclass(frozen=True, eq=False)
class BodyState(InnerState[WornBody]):
    """What a wire is like at one position of a cycle."""

    @cached_property
    def reaction_N(self) -> Array:
        """Forces of the grip on its nodes (h, 3) in N, from the stresses inside."""
        inner = self.body.points.internal_forces(self.stress_at_points) - self.applied
        return np.asarray(inner[self.body.mesh.surface_nodes("grip")])

    @cached_property
    def _surface_vectors(self) -> Array:
        """The area of the contact patch that belongs to each node, (n, 3) along the outward normal, mm²."""
        mesh = self.body.mesh
        facets = mesh.surfaces["contact"]
        corners = mesh.points[facets]
        areas = 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
        vectors = np.zeros_like(mesh.points)
        np.add.at(vectors, facets, 0.25 * areas[:, None])
        return vectors

    @property
    def surface_normal(self) -> Array:
        """Outward normals (n, 3) of the worn surface at the nodes of the contact patch, zero elsewhere."""
        size = np.linalg.norm(self._surface_vectors, axis=1)
        return np.asarray(self._surface_vectors / np.where(size > 0.0, size, 1.0)[:, None])

    @property
    def traction_MPa(self) -> Array:
        """Contact forces over the area of the worn surface that belongs to each node, (n, 3)."""
        size = np.linalg.norm(self._surface_vectors, axis=1)
        return np.asarray(self.applied / np.where(size > 0.0, size, 1.0)[:, None])


def body_states(
    result: RunResult, wire: str, cycle: float, at: Sequence[str | int] | None = None, *, worn: bool = True
) -> tuple[BodyState, ...]:
    """A wire of a run at positions of the cycle recorded nearest to `cycle`, all recorded ones by default.

    worn: the nodes stand in the worn surface and the forces act there; else they stand where they were when fresh, as
    in a run that does not move nodes.
    Raises ResultError if the run has recorded no such forces or positions, and GeometryError if wear distorts the mesh
    too much.
    """
    forces = result.forces(cycle, wire)
    chosen = list(range(len(forces.phase))) if at is None else [forces.position(one) for one in at]
    body = worn_body(result, wire, cycle, worn=worn)
    nodes = body.patch.nodes.ravel()[forces.nodes]
    upper = result.is_upper(wire)
    displacements = body.interior.displacements(nodes, forces.force_N[chosen])
    return tuple(BodyState(body, forces, k, moved, upper) for k, moved in zip(chosen, displacements, strict=True))


def worn_body(result: RunResult, wire: str, cycle: float, *, worn: bool = True) -> WornBody:
    """A wire as it was at the cycle recorded nearest to `cycle`; the last two asked for are kept with their factors.
    Raises ResultError if the run has recorded nothing of that wire near that cycle, and GeometryError if wear distorts
    the mesh too much.
    """
    forces = result.forces(cycle, wire)
    depth = None
    if worn:
        scar = result.scar(forces.cycle, wire)
        # A scar's transverse axis is that of the test, an upper body's own runs backwards.
        order = slice(None, None, -1 if result.is_upper(wire) else 1)
        depth = np.ascontiguousarray(np.maximum(1e-3 * scar.depth_um[:, order], 0.0))
    return _meshed(*forces.meshed, None if depth is None else depth.tobytes())


@lru_cache(maxsize=2)
def _meshed(geometry: BodyGeometry, material: Elastic, depth: bytes | None) -> WornBody:
    try:
        wire = _built(geometry.with_layering(geometry.layering.deeper(_DEEPER)), depth)
    except GeometryError:
        # There may be no room for more layers.
        wire = _built(geometry, depth)
    held = wire.mesh.surface_nodes("grip") if wire.bedding is None else np.zeros(0, dtype=np.int64)
    interior = Interior(wire.mesh, material, held, wire.bedding)
    return WornBody(wire, material, interior, integration_points(wire.mesh))


def _built(geometry: BodyGeometry, depth: bytes | None) -> BodyMesh:
    wire = build_body(geometry)
    worn = np.zeros(0) if depth is None else np.frombuffer(depth).reshape(wire.patch.shape)
    return wire.worn(worn) if worn.any() else wire
