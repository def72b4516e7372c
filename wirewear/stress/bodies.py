"""A body of a finished run at a point contact as it was at a recorded cycle, its state at positions of it, and grids of
that state.

A position is a recorded moment of a cycle. Grids are in µm, in the test's axes: x along the motion, z upwards.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, Protocol, Self, TypeVar

import numpy as np
from matplotlib.tri import Triangulation

from geometry import BodyGeometry, BodyMesh, Elastic, GeometryError, build_body
from geometry.arrays import Array, BoolArray, IntArray
from solvers.elasticity.embedding import Joined
from solvers.elasticity.linear_elasticity import hydrostatic, integration_points, principal, turned, von_mises
from solvers.stress.interior import EmbeddedInterior, Shared
from solvers.stress.surface_stress import SurfaceStress
from wirewear.results import ContactForces, RunResult
from wirewear.stress.state import InnerState, Inside, SolvedBody

T = TypeVar("T")

#: How far beside and beneath the patch, in half-widths of it, nodes move with what wears.
_REACH = 0.5


class WornBody(SolvedBody[BodyMesh]):
    """A body of a contact at a point, worn or fresh, with its factorised stiffness."""

    corrected = SurfaceStress

    @classmethod
    def of(
        cls, meshed: BodyMesh, material: Elastic, moving: BoolArray | None = None, shared: Shared | None = None
    ) -> Self:
        """The body with its stiffness ready to be solved; of a body from a file, block and surrounding elements
        together. moving, shared: as in `SolvedBody.of`. Raises GeometryError if the block holds elements of other
        materials.
        """
        if meshed.host is None:
            return super().of(meshed, material, moving, shared)
        if meshed.host.block_part.any():
            raise GeometryError(
                "stresses are computed of bodies from files that are of one material under their contact: name parts "
                "of other materials farther from it"
            )
        held, joined = meshed.mesh.surface_nodes("grip"), Joined.of(meshed, material)
        interior = EmbeddedInterior(meshed.mesh, material, held, joined=joined)
        return cls(meshed, material, interior, integration_points(meshed.mesh))


@dataclass(frozen=True, eq=False)
class BodyState(InnerState[WornBody]):
    """Displacements and stresses of a body at one position of a cycle; see `InnerState`."""

    @cached_property
    def _surface_vectors(self) -> Array:
        """The area of the contact patch that belongs to each node, (n, 3) along the outward normal, mm²."""
        mesh = self.body.mesh
        facets = mesh.surfaces["contact"]
        corners = mesh.points[facets]
        areas = 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
        vectors: Array = np.zeros_like(mesh.points)
        np.add.at(vectors, facets, 0.25 * areas[:, None])
        return vectors

    @property
    def surface_normal(self) -> Array:
        """Unit outward normals (n, 3) of the worn surface at nodes of the contact patch; zero at other nodes."""
        size = np.linalg.norm(self._surface_vectors, axis=1)
        return np.asarray(self._surface_vectors / np.where(size > 0.0, size, 1.0)[:, None])

    @property
    def traction_MPa(self) -> Array:
        """Traction (n, 3): contact force on each node over its area of the worn surface; zero beside the patch."""
        size = np.linalg.norm(self._surface_vectors, axis=1)
        return np.asarray(self.applied / np.where(size > 0.0, size, 1.0)[:, None])


def worn_body(result: RunResult, forces: ContactForces, worn: bool = True) -> WornBody:
    """The body that `forces` act on, with its nodes in the surface as worn then, or as fresh if not worn; the last two
    asked for are kept. Raises GeometryError if wear distorts the mesh too much.
    """
    return _meshed(*forces.meshed, _depth(result, forces) if worn else None)


def meshed_body(result: RunResult, forces: ContactForces) -> BodyMesh:
    """The mesh of the run of the body that `forces` act on, its nodes in the surface as worn then. Raises GeometryError
    if wear distorts it too much.
    """
    return _built(forces.meshed[0], _depth(result, forces))


def _depth(result: RunResult, forces: ContactForces) -> bytes:
    """Worn depth in mm at the nodes of a body's patch, as the bytes of its array, by which meshes are kept."""
    # A scar's transverse axis is that of the test, an upper body's own runs backwards.
    order = slice(None, None, -1 if result.is_upper(forces.body) else 1)
    scar = result.scar(forces.cycle, forces.body)
    return np.ascontiguousarray(np.maximum(1e-3 * scar.depth_um[:, order], 0.0)).tobytes()


@lru_cache(maxsize=2)
def _meshed(geometry: BodyGeometry, material: Elastic, depth: bytes | None) -> WornBody:
    # Layers under the patch over those of the run. Its pressures need no more, but stresses two or three half-widths
    # deep.
    deeper = geometry.with_layering(geometry.layering.deeper(1.4))
    # What wears may distort the elements beneath it too much, and there may be no room for more layers.
    for of_mesh, reach in ((deeper, _REACH), (deeper, np.inf)):
        with suppress(GeometryError):
            moving = _fresh(of_mesh).beneath_patch(reach)
            return WornBody.of(_built(of_mesh, depth, moving), material, moving, _shared(of_mesh, material, reach))
    return WornBody.of(_built(geometry, depth), material)


def _built(geometry: BodyGeometry, depth: bytes | None, moving: BoolArray | None = None) -> BodyMesh:
    body = _fresh(geometry)
    worn = np.zeros(0) if depth is None else np.frombuffer(depth).reshape(body.patch.shape)
    return body.worn(worn, moving) if worn.any() else body


@lru_cache(maxsize=1)
def _shared(_geometry: BodyGeometry, _material: Elastic, _reach: float) -> Shared:
    """What the states of wear of one body share."""
    return Shared()


#: What wears is the same mesh in all states of a body.
_fresh = lru_cache(maxsize=2)(build_body)


if TYPE_CHECKING:
    import pyvista


@dataclass(frozen=True, eq=False)
class Section:
    """A cut through a body: positions (n,) in µm along and in height, triangles (t, 3), values (n,) of a field."""

    along: Array
    height: Array
    triangles: IntArray
    values: Array

    @property
    def places(self) -> Triangulation:
        """Triangulation of the section for matplotlib."""
        return Triangulation(self.along, self.height, self.triangles)


def section(grid: pyvista.UnstructuredGrid, axis: int, at_um: float, field: str = "von_mises_MPa") -> Section:
    """The cut through a mesh at x (axis 0) or y (axis 1) = `at_um`; along it runs the other coordinate. field: name of
    the point data that it shows.
    """
    normal = np.eye(3)[axis]
    # Mirror planes are full of faces that would be cut twice.
    origin = tuple(normal * (at_um + 1e-4))
    cut = grid.slice(normal=tuple(normal), origin=origin, generate_triangles=False)
    values = np.asarray(cut.point_data[field]) if cut.n_points else np.zeros(0)
    return fanned(np.asarray(cut.points)[:, [1 - axis, 2]], values, cut.irregular_faces if cut.n_cells else ())


def plane_section(
    grid: pyvista.UnstructuredGrid, field: str = "von_mises_MPa", *, within: IntArray | None = None
) -> Section:
    """The body of a line contact as a section along x: its quadrilaterals whose corners are all in `within` (nodes;
    None: all). field: name of the point data.
    """
    quads = np.asarray(grid.cells).reshape(-1, 5)[:, 1:]
    if within is not None:
        quads = quads[np.isin(quads, within).all(axis=1)]
    return fanned(np.asarray(grid.points)[:, [0, 2]], np.asarray(grid.point_data[field]), quads)


def fanned(points: Array, values: Array, polygons: Iterable[IntArray]) -> Section:
    """A section of polygons of points (n, 2), each cut into as many triangles about its middle as it has sides. values
    (n,): of a field; polygons: indices of their corners.

    Two triangles on one of a quadrilateral's diagonals would make contours of what is symmetric look slanted.
    """
    faces = [np.asarray(polygon) for polygon in polygons]
    triangles, middles, means = [np.zeros((0, 3), dtype=np.int64)], [points], [values]
    first = len(points)
    for corners in sorted({len(face) for face in faces}):
        alike = np.array([face for face in faces if len(face) == corners])
        middle = first + np.arange(len(alike))
        triangles += [np.column_stack([alike[:, k], alike[:, (k + 1) % corners], middle]) for k in range(corners)]
        middles.append(points[alike].mean(axis=1))
        means.append(values[alike].mean(axis=1))
        first += len(alike)
    where = np.vstack(middles)
    return Section(where[:, 0], where[:, 1], np.vstack(triangles), np.concatenate(means))


class Tracked(Protocol):
    """A function that passes on the items of a sequence and may show progress."""

    def __call__(self, each: Sequence[T], doing: str, /) -> Iterable[T]:
        """Yield the items in their order; `doing` says what is done with them."""


def untracked(each: Sequence[T], _doing: str, /) -> Iterable[T]:
    """The items of `each`, without any display of progress."""
    return each


def body_grid(state: BodyState) -> pyvista.UnstructuredGrid:
    """A body's hexahedra in µm, in the test's axes, where they are at that moment but for the elastic displacement.

    Point data: displacement_um, stress_MPa (xx, yy, zz, xy, yz, xz), von_mises_MPa, tresca_MPa, principal_MPa (largest
    first), hydrostatic_MPa, contact_traction_MPa, worn_depth_um, gripped. Cell data: von_mises_MPa, the mean over the
    integration points, and scaled_jacobian. Field data: cycle, position, drive_um.
    """
    import pyvista

    grid = stressed_grid(state, pyvista.CellType.HEXAHEDRON)
    grid.point_data["contact_traction_MPa"] = state.traction_MPa @ state.to_world.T
    patch = state.body.patch
    depth = np.zeros(len(state.body.mesh.points))
    if patch.repositioned_depth_mm is not None:
        depth[patch.nodes] = 1e3 * patch.repositioned_depth_mm
    grid.point_data["worn_depth_um"] = depth
    marked = np.zeros(len(depth))
    marked[state.body.mesh.surface_nodes("grip")] = 1.0
    grid.point_data["gripped"] = marked
    forces = state.forces
    grid.field_data["cycle"] = [forces.cycle]
    grid.field_data["position"] = [state.position]
    grid.field_data["drive_um"] = [forces.drive_um[state.position]]
    grid.set_active_scalars("von_mises_MPa", preference="point")
    return grid


INSIDE_POINTS = Inside(BodyState, worn_body, lambda _, forces: forces.meshed[0].least_extent_mm, body_grid)
body_states = INSIDE_POINTS.states


def stressed_grid(state: InnerState[Any], kind: pyvista.CellType) -> pyvista.UnstructuredGrid:
    """A body's elements in µm, in the test's axes, all cells of `kind`, with the point and cell data that bodies of any
    dimension have.

    Point data: displacement_um, stress_MPa, von_mises_MPa, tresca_MPa, principal_MPa, hydrostatic_MPa;
    residual_stress_MPa of a body with any; at the surface's nodes interface_layer_MPa and interface_body_MPa, of both
    sides where layers of another material meet the body beneath. Cell data: von_mises_MPa, scaled_jacobian. Field data:
    bulk_stress_MPa of a body that carries any.
    """
    import pyvista

    mesh, turn = state.body.mesh, state.to_world
    stress = turned(state.stress, turn)
    values = principal(stress)
    grid = pyvista.UnstructuredGrid({kind: mesh.cells}, state.world_points_um(state.places_mm))
    points, cells = grid.point_data, grid.cell_data
    points["displacement_um"] = 1e3 * state.displacement @ turn.T
    points["stress_MPa"] = stress
    if state.residual is not None:
        points["residual_stress_MPa"] = turned(state.residual.at_nodes, turn)
    if state.at_interface is not None:
        for side, found in zip(("layer", "body"), state.at_interface, strict=True):
            points[f"interface_{side}_MPa"] = np.zeros_like(stress)
            points[f"interface_{side}_MPa"][state.patch_nodes] = turned(found, turn)
    points["von_mises_MPa"] = von_mises(stress)
    points["tresca_MPa"] = values[:, 0] - values[:, 2]
    points["principal_MPa"] = values
    points["hydrostatic_MPa"] = hydrostatic(stress)
    cells["von_mises_MPa"] = von_mises(state.stress_at_points).mean(axis=1)
    cells["scaled_jacobian"] = mesh.quality
    if state.forces.bulk_stress_MPa is not None:
        grid.field_data["bulk_stress_MPa"] = state.forces.bulk_stress_MPa[state.position]
    return grid


def integration_point_cloud(state: BodyState) -> pyvista.PolyData:
    """The integration points of a body in µm, in the test's axes, with stress_MPa and von_mises_MPa as computed."""
    import pyvista

    points = state.body.points.positions.reshape(-1, 3)
    cloud = pyvista.PolyData(state.world_points_um(points))
    stress = turned(state.stress_at_points.reshape(-1, 6), state.to_world)
    cloud.point_data["stress_MPa"] = stress
    cloud.point_data["von_mises_MPa"] = von_mises(stress)
    return cloud
