"""What a body is like at one position of a cycle, whatever its dimension: stresses from displacements, in one place."""

from dataclasses import dataclass
from functools import cached_property
from typing import Generic, Protocol, TypeVar

import numpy as np

from geometry import ContactPatch, Elastic, HexMesh, QuadMesh
from geometry.arrays import Array, IntArray
from solvers.placement import rotation_to_world
from solvers.strain import IntegrationPoints, scattered
from wirewear.results import ContactForces


class SurfaceLoads(Protocol):
    """A contact surface under forces."""

    def edge(self) -> Array:
        """Points (k, 2) of the patch at which the contact ends."""

    def correction(self, points_mm: Array) -> Array:
        """What the elements' stress lacks at points (k, 2) of the patch, (k, 6) in MPa."""


class Surface(Protocol):
    """A contact surface whose stresses can be corrected between the nodes."""

    def under(self, force: Array, /) -> SurfaceLoads:
        """The surface under forces (n, 3) at the nodes of its patch."""


class MeshedBody(Protocol):
    """A body with its mesh, its contact patch and its integration points."""

    @property
    def mesh(self) -> HexMesh | QuadMesh:
        """Its elements."""

    @property
    def patch(self) -> ContactPatch:
        """Its contact patch."""

    @property
    def material(self) -> Elastic:
        """Its material."""

    @property
    def points(self) -> IntegrationPoints:
        """Its integration points."""

    @property
    def surface(self) -> Surface:
        """Its contact patch, for corrections of the stresses there."""


B = TypeVar("B", bound=MeshedBody)


@dataclass(frozen=True, eq=False)
class InnerState(Generic[B]):
    """A body at one position of a cycle; all in the body's own axes, lengths in mm, stresses in MPa.

    position: its place in `forces`.  displacement: (n, 3) of the nodes.  is_upper: it stands above and is held.
    """

    body: B
    forces: ContactForces
    position: int
    displacement: Array
    is_upper: bool

    @cached_property
    def stress_at_points(self) -> Array:
        """Stresses (m, q, 6) at the integration points of the m elements: what the finite elements compute."""
        return self.body.points.stresses(self.body.material, self.displacement)

    @cached_property
    def stress(self) -> Array:
        """Stresses (n, 6) projected to the nodes."""
        return self.body.points.at_nodes(self.stress_at_points)

    @cached_property
    def applied(self) -> Array:
        """Contact forces (n, 3) on all nodes in N, of a planar body in N/mm."""
        force = np.zeros((len(self.body.mesh.points), 3))
        force[self.loaded_nodes] = self.forces.force_N[self.position]
        return force

    @property
    def patch_nodes(self) -> IntArray:
        """Nodes of the mesh on the contact patch, in the order of the patch's flattened grid."""
        return self.body.patch.nodes.ravel()

    @property
    def loaded_nodes(self) -> IntArray:
        """Nodes of the mesh that carry force at any position of the cycle."""
        return np.asarray(self.patch_nodes[self.forces.nodes])

    @property
    def places_mm(self) -> Array:
        """The nodes (n, 3); those of a planar body at y = 0."""
        points = self.body.mesh.points
        if points.shape[1] == 3:
            return points
        return np.column_stack([points[:, 0], np.zeros(len(points)), points[:, 1]])

    @property
    def node_sizes(self) -> Array:
        """Volume (n,) of the body that belongs to each node, mm³ or per mm of thickness."""
        points, mesh = self.body.points, self.body.mesh
        shares = np.einsum("mq,qc->mc", points.volumes, points.shapes)
        return scattered(mesh.cells, shares[:, :, None], len(mesh.points))[:, 0]

    @property
    def name(self) -> str:
        """Which body it is."""
        return self.forces.body

    @property
    def to_world(self) -> Array:
        """The matrix (3, 3) from the body's axes to the test's: x along the motion, z towards the upper body."""
        return rotation_to_world(upper=self.is_upper, axis_angle_rad=float(np.radians(self.forces.axis_angle_deg)))

    @property
    def origin_um(self) -> Array:
        """Where the body's first point of contact is in the axes of the test, moved with its holder, (3,)."""
        forces, k = self.forces, self.position
        if self.is_upper:
            return np.array([forces.holder_x_um[k], 0.0, forces.holder_z_um[k]])
        return np.array([forces.drive_um[k], 0.0, 0.0])

    def world_points_um(self, points_mm: Array) -> Array:
        """Points (k, 3) of the body's own axes in the axes of the test, in µm."""
        return np.asarray(1e3 * points_mm @ self.to_world.T + self.origin_um)
