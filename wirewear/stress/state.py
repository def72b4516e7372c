"""A body at one position of a cycle: its stresses from displacements, and their averages over a length.

A position is a recorded moment of a cycle. Stresses are rows of xx, yy, zz, xy, yz, xz in MPa. A body's own axes run
along its axis, across it and out of its surface, from the point of first contact.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Self, TypeVar

import numpy as np
from scipy.sparse import csr_matrix, diags
from scipy.spatial import cKDTree
from threadpoolctl import threadpool_limits

from geometry import BodyMesh, ContactPatch, Elastic, PlanarMesh, QuadMesh
from geometry.arrays import Array, BoolArray, IntArray
from solvers.bulk_stress import section_stress
from solvers.elasticity.linear_elasticity import IntegrationPoints, integration_points, interpolation, scattered
from solvers.elasticity.placement import rotation_to_world
from solvers.stress.coats import SIDE, CoatStress, across_interface
from solvers.stress.interior import Interior, Shared
from solvers.stress.line_surface_stress import LineSurfaceStress
from solvers.stress.surface_stress import SurfaceStress
from wirewear.results import ContactForces, RunResult
from wirewear.stress.coats import coats_of
from wirewear.stress.residual import Residual, residual_of, with_friction_borne

if TYPE_CHECKING:
    import pyvista


M = TypeVar("M", BodyMesh, PlanarMesh)


@contextmanager
def one_thread() -> Iterator[None]:
    """A context, also a decorator, within which linear algebra has one thread: with small matrices, several that wait
    for each other cost ten times what they gain on a busy machine.
    """
    with threadpool_limits(limits=1, user_api="blas"):
        yield


@dataclass(frozen=True, eq=False)
class SolvedBody(Generic[M]):
    """A meshed body, worn or fresh, with its stiffness matrix factorised (interior) to find stresses at its integration
    points under any contact forces. plane: True for plane strain.
    """

    #: What corrects the stresses at its contact surface between the nodes.
    corrected: ClassVar[type[SurfaceStress] | type[LineSurfaceStress]]
    plane: ClassVar[bool] = False
    meshed: M
    material: Elastic
    interior: Interior
    points: IntegrationPoints

    @classmethod
    def of(cls, meshed: M, material: Elastic, moving: BoolArray | None = None, shared: Shared | None = None) -> Self:
        """The body with its stiffness ready to be solved for any forces; held rigidly at its grip, or elastically if
        the mesh has a bedding. shared: what is known of bodies that differ from it in wear, by which only nodes
        `moving` (n,) stand elsewhere; what its own factors add is kept there.
        """
        held = meshed.mesh.surface_nodes("grip") if meshed.bedding is None else np.zeros(0, dtype=np.int64)
        interior = Interior(meshed.mesh, material, held, meshed.bedding, moving, shared or Shared())
        return cls(meshed, material, interior, integration_points(meshed.mesh))

    @property
    def mesh(self) -> Any:
        return self.meshed.mesh

    @property
    def patch(self) -> ContactPatch:
        return self.meshed.patch

    @property
    def outer_faces(self) -> IntArray:
        """Corner nodes (f, 4) of the elements' faces that may touch."""
        faces: IntArray = self.mesh.surfaces["contact"]
        return faces

    @cached_property
    def surface(self) -> Any:
        """The contact surface as an object of class `corrected`, which corrects stresses near it between the nodes."""
        made: Any = self.corrected
        return made.of(self.meshed, self.material)


B = TypeVar("B", bound=SolvedBody[Any])


@dataclass(frozen=True, eq=False)
class InnerState(Generic[B]):
    """A body at one position of a cycle; all in the body's own axes, lengths in mm, stresses in MPa.

    position: its index in `forces`. displacement (n, 3): of the mesh's nodes. is_upper: True for the held body.
    residual: stress that the first cycles have left in it, None for none. coat: what layers change, None for none.
    """

    body: B
    forces: ContactForces
    position: int
    displacement: Array
    is_upper: bool
    residual: Residual | None = None
    coat: CoatStress | None = None

    @classmethod
    def of(
        cls,
        body: B,
        forces: ContactForces,
        positions: Sequence[int],
        *,
        is_upper: bool,
        residual: Residual | None = None,
        coats: Sequence[CoatStress | None] = (),
    ) -> tuple[Self, ...]:
        """States of a body at chosen positions of a recorded cycle, given as indices into `forces`, in their order.
        is_upper, residual: as in the class; coats: of each position, none for no layers.
        """
        positions = list(positions)
        nodes = body.patch.nodes.ravel()[forces.nodes]
        displacements = body.interior.displacements(nodes, forces.force_N[positions])
        return tuple(
            cls(body, forces, k, moved, is_upper, residual, coat)
            for k, moved, coat in zip(positions, displacements, coats or [None] * len(positions), strict=True)
        )

    @cached_property
    def stress_at_points(self) -> Array:
        """Stresses (m, q, 6) at the integration points of the m elements."""
        points = self.body.points
        found = points.stresses(self.body.material, self.displacement)
        found += self.bulk(points.positions.reshape(-1, points.positions.shape[-1])).reshape(found.shape)
        if self.coat is not None:
            found += self.by_coat(points.positions.reshape(-1, points.positions.shape[-1])).reshape(found.shape)
        return found if self.residual is None else found + self.residual.at_points

    def by_coat(self, places_mm: Array) -> Array:
        """What layers change of the stresses (k, 6) at places (k, d) of the mesh; zero without layers."""
        if self.coat is None:
            return np.zeros((len(places_mm), 6))
        plane = places_mm[:, :2] if places_mm.shape[1] == 3 else _beneath(places_mm)[:, :2]
        return self.coat.at(plane, self.body.patch.height(plane) - places_mm[:, -1])

    @cached_property
    def at_interface(self) -> tuple[Array, Array] | None:
        """Stresses (p, 6) where the lowest layer meets the body, in the layer and in the body, beneath the patch's
        nodes; None without layers.
        """
        if self.coat is None:
            return None
        mesh, thickness = self.body.mesh, self.coat.coating.thickness_mm
        plane = self.body.patch.grid()
        places = np.column_stack([plane, self.body.patch.height(plane) - thickness])
        taken = interpolation(mesh, places[:, [0, 2]] if isinstance(mesh, QuadMesh) else places)
        depth = np.full(len(plane), (1.0 + SIDE) * thickness)
        beneath = taken @ (self.stress - self.by_coat(mesh.points)) + self.coat.at(plane, depth)
        return across_interface(beneath, self.body.material, self.coat.coating.layers[-1][1]), beneath

    def bulk(self, places_mm: Array) -> Array:
        """Bulk stresses (k, 6) at places (k, d) of the mesh, of a bar whose axis lies at the middle of the body's
        height.
        """
        found, bulk = np.zeros((len(places_mm), 6)), self.forces.bulk_stress_MPa
        mesh = self.body.mesh
        if bulk is None:
            return found
        across = 0.0
        if isinstance(mesh, QuadMesh):
            places_mm, across = _beneath(places_mm), self.body.material.poissons_ratio
        depth = -0.5 * float(mesh.points[:, -1].min())
        return found + section_stress(bulk[self.position], places_mm, depth, across)

    @cached_property
    def stress(self) -> Array:
        """Stresses (n, 6) at the nodes, those by the contact's forces projected to them."""
        points = self.body.mesh.points
        (found,) = self.body.interior.stresses(self.displacement[None], np.arange(len(points)))
        found = found + self.bulk(points)
        found = found if self.coat is None else found + self.by_coat(points)
        return np.asarray(found if self.residual is None else found + self.residual.at_nodes)

    @cached_property
    def applied(self) -> Array:
        """Contact forces (n, 3) on all nodes in N, of a planar body in N/mm."""
        force = np.zeros((len(self.body.mesh.points), 3))
        force[self.loaded_nodes] = self.forces.force_N[self.position]
        return force

    @property
    def patch_nodes(self) -> IntArray:
        """Indices (p,) of the mesh's nodes on the contact patch, in the order of the patch's flattened grid."""
        return self.body.patch.nodes.ravel()

    @property
    def loaded_nodes(self) -> IntArray:
        """Indices of the mesh's nodes that carry force at any position of the cycle."""
        return np.asarray(self.patch_nodes[self.forces.nodes])

    @property
    def places_mm(self) -> Array:
        """Places (n, 3) of the nodes; those of a planar body have y = 0."""
        points = self.body.mesh.points
        return points if points.shape[1] == 3 else _beneath(points)

    @property
    def node_sizes(self) -> Array:
        """Volume (n,) that belongs to each node in mm³; of a planar body area in mm²."""
        points, mesh = self.body.points, self.body.mesh
        shares = np.einsum("mq,qc->mc", points.volumes, points.shapes)
        return scattered(mesh.cells, shares[:, :, None], len(mesh.points))[:, 0]

    @property
    def name(self) -> str:
        return self.forces.body

    @property
    def to_world(self) -> Array:
        """The matrix (3, 3) that turns vectors of the body's axes into the test's: x along the motion, z upwards."""
        return rotation_to_world(upper=self.is_upper, axis_angle_rad=float(np.radians(self.forces.axis_angle_deg)))

    @property
    def origin_um(self) -> Array:
        """Position (3,) in µm of the body's point of first contact, moved with its holder, in the test's axes."""
        forces, k = self.forces, self.position
        if self.is_upper:
            return np.array([forces.holder_x_um[k], 0.0, forces.holder_z_um[k]])
        return np.array([forces.drive_um[k], 0.0, 0.0])

    def world_points_um(self, points_mm: Array) -> Array:
        """Points (k, 3) given in the body's own axes in mm, in the test's axes in µm."""
        return np.asarray(1e3 * points_mm @ self.to_world.T + self.origin_um)


S = TypeVar("S", bound=InnerState[Any])


@dataclass(frozen=True)
class Inside(Generic[S]):
    """Functions that give stress states and grids of the bodies of contacts at a point, or of line contacts.

    state: class of states. body: from a result, contact forces and whether nodes stand in the worn surface, to the
    body. least_extent_mm: its least extent, from a result and forces. grid: of a state, in µm.
    """

    state: type[S]
    body: Callable[[RunResult, ContactForces, bool], Any]
    least_extent_mm: Callable[[RunResult, ContactForces], float]
    grid: "Callable[[S], pyvista.UnstructuredGrid]"

    def states(
        self, result: RunResult, body: str, cycle: float, at: Sequence[str | int] | None = None, *, worn: bool = True
    ) -> tuple[S, ...]:
        """States of a body of a run at positions `at`, names or indices from 0 (None: all), of the cycle with recorded
        forces that is nearest to `cycle` by ratio.

        worn: the nodes stand in the worn surface and the forces act there; else they stand where they were when fresh,
        as in a run that does not move nodes. Raises ResultError if the run has recorded no such forces or positions,
        and GeometryError if wear distorts the mesh too much.
        """
        result = result.computed
        forces = result.forces(cycle, body)
        chosen = list(range(len(forces.phase))) if at is None else [forces.position(one) for one in at]
        of_body = self.body(result, forces, worn)
        forces = with_friction_borne(result, forces, of_body.patch)
        solved = of_body.points, of_body.interior, of_body.material
        residual = residual_of(result, forces, of_body.patch, *solved)
        coats = coats_of(result, forces, of_body.patch, of_body.material, chosen)
        found = self.state.of(of_body, forces, chosen, is_upper=result.is_upper(body), residual=residual, coats=coats)
        if at is None:
            # Of a whole cycle no displacements are left to be found; factors are most of the memory.
            of_body.interior.forget()
        return found


def _beneath(points: Array) -> Array:
    """Points (n, 2) of a planar body at y = 0, (n, 3)."""
    return np.column_stack([points[:, 0], np.zeros(len(points)), points[:, 1]])


def averaging(points_mm: Array, volumes_mm3: Array, chosen: IntArray, diameter_mm: float) -> csr_matrix:
    """The matrix (k, n) of means over balls (discs) of `diameter_mm` about the k points with indices `chosen`, weighted
    by the volumes (n,) of all points. What gradients beneath a contact ask for: a material's crack needs stress over a
    length, not at a point (Taylor, Int. J. Fatigue 21 (1999) 413). A diameter of 0 or less leaves values as they are.
    """
    size = len(points_mm)
    if diameter_mm <= 0.0:
        return csr_matrix((np.ones(len(chosen)), (np.arange(len(chosen)), chosen)), shape=(len(chosen), size))
    near = cKDTree(points_mm).query_ball_point(points_mm[chosen], 0.5 * diameter_mm)
    counts = np.array([len(each) for each in near])
    columns = np.concatenate([np.asarray(each, dtype=np.int64) for each in near])
    rows = np.repeat(np.arange(len(chosen)), counts)
    weights = csr_matrix((volumes_mm3[columns], (rows, columns)), shape=(len(chosen), size))
    return csr_matrix(diags(1.0 / np.asarray(weights.sum(axis=1)).ravel()) @ weights)
