"""A body from a mesh file with a block of hexahedra made by this program under its contact patch.

The block has the file's face, fitted smoothly, and replaces the file's elements there: of each of these only the share
outside the block counts. The block's sides and back move as the file's elements do (see `host` for the seam). Where the
file's elements under the contact are hexahedra on a grid, they may be used unchanged instead.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from geometry.arrays import Array, BoolArray, IntArray
from geometry.body import LEAST_SCALED_JACOBIAN, BodyGeometry, BodyMesh, swept_body
from geometry.elements import BRICK, QUADRILATERAL
from geometry.errors import GeometryError
from geometry.grading import GivenAxis, Layering
from geometry.mesh import HexMesh
from geometry.own_surface import FittedFace, MeshSource, OwnSurface, own_surface
from geometry.patch import ContactPatch
from geometry.shapes import BlockGeometry
from geometry.solid import BlockSeam, Host, SolidMesh

_SAMPLES = 6  #: Points along each edge of an element at which it is seen how much of it the block holds.
_LEAST_SHARE = 1e-8  #: Least share of an element's stiffness that is kept, so that nodes inside the block are held.
#: How far the block's sides and back may lie beyond the file's elements, whose faces are chords of a round surface,
#: over the elements' size.
_BEYOND = 0.15
_POINTS = 3  #: Points each way of a face of the block at which it hangs on the file's elements.


@dataclass(frozen=True)
class EmbeddedGeometry(BlockGeometry):
    """A block of hexahedra with the face of the body in a mesh file, `source`, embedded in that body; other fields as
    in `BlockGeometry`.
    """

    source: MeshSource = field(kw_only=True)

    @property
    def own(self) -> OwnSurface:
        return own_surface(self.source)

    @property
    def profile(self) -> FittedFace:
        return self.own.face

    @property
    def meshed_profile(self) -> FittedFace:
        return self.own.face

    def bent(self, points_mm: Array) -> Array:
        """Points (n, 3) unchanged: the face need not be symmetric, so `fitted` bends the whole mesh instead."""
        return points_mm

    def fitted(self, points_mm: Array) -> Array:
        """Points (n, 3) of the straight block moved so that its top has the face of the file's body."""
        return super().bent(points_mm)

    def built(self) -> BodyMesh:
        """The mesh of the block, with the file's elements around it as host. Raises GeometryError if the block reaches
        beyond these.
        """
        meshed = swept_body(self)
        return BodyMesh(self, meshed.mesh, meshed.patch, meshed.smallest_scaled_jacobian, self._host(meshed.mesh))

    def holds(self, places_mm: Array) -> BoolArray:
        """(...) True for places (..., 3) in mm within the block's sides, less than its height below or above z = 0."""
        x, y, z = np.moveaxis(places_mm, -1, 0)
        beside = (np.abs(x) >= self.half_width_along_mm) | (np.abs(y) >= self.half_width_across_mm)
        return np.asarray(~beside & (np.abs(z) < self.height_mm))

    def _host(self, block: HexMesh) -> Host:
        solid, source = self.own.solid, self.source
        seam = _seam(block, solid)
        beyond = seam.places.beyond_mm / solid.edges_mm[seam.places.cell]
        if beyond.max() > _BEYOND:
            place = ", ".join(
                f"{at:.4g}" for at in block.points[block.cells[seam.cells]].mean(axis=1)[beyond.argmax() // _POINTS**2]
            )
            raise GeometryError(
                f"the block that is meshed under the contact reaches beyond the file's elements at ({place}) mm: give "
                "a contact farther from the body's edges, or a lower load, stroke or wear"
            )
        part = np.zeros(solid.size, dtype=np.int64)
        for number, (name, *_) in enumerate(source.parts, 1):
            part[np.concatenate([solid.parts[name][count] for count in solid.cells])] = number
        points = np.einsum("qc,mcd->mqd", BRICK.shapes(BRICK.points), block.points[block.cells])
        return Host(
            solid,
            self._kept(solid),
            seam,
            solid.sets[source.held],
            solid.areas_of(source.held),
            part,
            part[solid.located(points.reshape(-1, 3)).cell].reshape(points.shape[:2])
            if source.parts
            else np.zeros(points.shape[:2], dtype=np.int64),
            tuple((modulus, ratio) for _, modulus, ratio in source.parts),
        )

    def _kept(self, solid: SolidMesh) -> Array:
        """Share (size,) of each of the file's cells that lies outside the block."""
        shares = []
        for kind, cells in solid.groups:
            steps = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
            low, high = kind.nodes.min(axis=0), kind.nodes.max(axis=0)
            at = low + (high - low) * np.stack(np.meshgrid(*3 * [steps], indexing="ij"), axis=-1).reshape(-1, 3)
            shapes = kind.shapes(at[kind.outside(at) <= 0.0])
            corners = solid.points[cells]
            near = (corners.min(axis=1) < self._corner).all(axis=1) & (corners.max(axis=1) > -self._corner).all(axis=1)
            share = np.ones(len(cells))
            share[near] = 1.0 - self.holds(np.einsum("qn,mni->mqi", shapes, corners[near])).mean(axis=1)
            shares.append(share)
        return np.maximum(np.concatenate(shares), _LEAST_SHARE)

    @property
    def _corner(self) -> Array:
        return np.array([self.half_width_along_mm, self.half_width_across_mm, self.height_mm])


def _seam(block: HexMesh, solid: SolidMesh) -> BlockSeam:
    """Integration points on the sides and the back of a block, with their places in the file's mesh."""
    x, w = np.polynomial.legendre.leggauss(_POINTS)
    on_face = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    shares, slopes = QUADRILATERAL.shapes(on_face), QUADRILATERAL.slopes(on_face)
    wanted = {tuple(row) for row in np.sort(block.surfaces["grip"], axis=1).tolist()}
    cells, local, areas = [], [], []
    for face in BRICK.faces:
        corners = block.cells[:, list(face)]
        near = np.flatnonzero(np.isin(corners, block.surface_nodes("grip")).all(axis=1))
        own = near[[tuple(row) in wanted for row in np.sort(corners[near], axis=1).tolist()]]
        at = block.points[corners[own]]
        cells.append(own)
        local.append(np.tile(shares @ BRICK.nodes[list(face)], (len(own), 1, 1)))
        normal = np.cross(*np.einsum("qck,fci->kfqi", slopes, at))
        areas.append(normal * np.outer(w, w).ravel()[:, None])
    cell, where, area = np.concatenate(cells), np.concatenate(local), np.concatenate(areas)
    places = np.einsum("fqc,fci->fqi", BRICK.shapes(where), block.points[block.cells[cell]])
    size = np.linalg.norm(area, axis=2).sum(axis=1)
    depth = HexMesh(block.points, block.cells[cell], {}).cell_volumes() / size
    return BlockSeam(cell, where, area, depth, solid.located(places.reshape(-1, 3)))


def block_fits(own: OwnSurface, half_widths_mm: tuple[float, float], height_mm: float) -> bool:
    """True if a block of these half-widths (along, across) and height, under the fitted face, lies within the file's
    elements or beside them by at most 15 % of their size.
    """
    steps = np.linspace(-1.0, 1.0, 7)
    plane = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2) * np.array(half_widths_mm)
    top = own.face.height(plane)
    rim = (np.abs(plane) >= np.array(half_widths_mm) * (1.0 - 1e-9)).any(axis=1)
    places = [np.column_stack([plane, np.full(len(plane), -height_mm)])]
    places += [np.column_stack([plane[rim], top[rim] * (1.0 - s) - s * height_mm]) for s in (0.05, 0.5)]
    found = own.solid.located(np.vstack(places))
    beyond = (found.beyond_mm / own.solid.edges_mm[found.cell]).max()
    return bool(top.min() > -0.8 * height_mm and beyond <= _BEYOND)


@dataclass(frozen=True)
class OwnGrid(BodyGeometry):
    """The hexahedra of the mesh file `source` used unchanged, since their contact surface is a grid; other fields as in
    `BodyGeometry`.
    """

    source: MeshSource
    axial: GivenAxis
    transverse: GivenAxis
    coarse_mm: float
    grip_stiffness_N_per_mm3: float | None = None
    layering: Layering = field(default_factory=Layering)

    @property
    def profile(self) -> FittedFace:
        return own_surface(self.source).face

    @property
    def half_length_mm(self) -> float:
        return float(np.abs(own_surface(self.source).solid.points[:, 0]).max())

    @property
    def least_extent_mm(self) -> float:
        return float(np.ptp(own_surface(self.source).solid.points, axis=0).min())

    def with_layering(self, layering: Layering) -> OwnGrid:
        """This geometry unchanged: the file's elements keep their layers."""
        del layering
        return self

    def section(self) -> tuple[Array, IntArray]:
        """Raise GeometryError, always: a file's elements are not swept from a section."""
        raise GeometryError("a file's elements are not swept from a section; please report this study")

    def gripped(self, centres_mm: Array) -> BoolArray:
        """(n,) False for all facets: the grip is the file's set, which `built` names."""
        return np.zeros(len(centres_mm), dtype=bool)

    def built(self) -> BodyMesh:
        """The mesh of the file's elements, with named surfaces. Raises GeometryError if their contact surface is no
        grid, or an element is too distorted.
        """
        solid, found = own_surface(self.source).solid, grid_of(self.source)
        if found is None:
            raise GeometryError("the file's contact surface is no grid; please report this study")
        held, contact = solid.faces_of(self.source.held)[1], found.facets()
        known = np.sort(np.vstack([contact, held]), axis=1)
        rows = {tuple(row) for row in known.tolist()}
        others = solid.boundary[1]
        side = others[[tuple(row) not in rows for row in np.sort(others, axis=1).tolist()]]
        surfaces = {"contact": contact, "grip": held, "side": side, "ends": side[:0]}
        mesh = HexMesh(solid.points, solid.cells[8], surfaces)
        return BodyMesh(self, mesh, found, mesh.require_quality(LEAST_SCALED_JACOBIAN))


@lru_cache(maxsize=4)
def grid_of(source: MeshSource) -> ContactPatch | None:
    """The contact patch of a file's body; None unless its contact surface is a grid over the plane and all elements are
    hexahedra of one material.
    """
    own = own_surface(source)
    solid = own.solid
    triangles, quads = solid.faces_of(source.contact)
    if source.parts or set(solid.cells) != {8} or len(triangles) or not len(quads):
        return None
    found = on_grid(solid.points[:, :2], np.unique(quads))
    if found is None or len(quads) != np.prod(np.array(found[1].shape) - 1):
        return None
    (along, across), grid = found
    try:
        return ContactPatch(along, across, grid, own.face)
    except GeometryError:
        # It reaches to where the face is steep.
        return None


def on_grid(places_mm: Array, nodes: IntArray) -> tuple[list[Array], IntArray] | None:
    """The grid that nodes lie on: its lines [(n_a,), (n_t,)] in mm, and the node (n_a, n_t) at each crossing; None
    unless they form one with three lines each way.

    places_mm: (n, 2) of all nodes in the plane. nodes: indices of those looked at.
    """
    places = places_mm[nodes]
    axes = [_lines(places[:, axis]) for axis in (0, 1)]
    if len(axes[0]) * len(axes[1]) != len(nodes) or min(map(len, axes)) < 3:
        return None
    grid = np.full((len(axes[0]), len(axes[1])), -1, dtype=np.int64)
    i, j = (np.abs(places[:, axis, None] - axes[axis]).argmin(axis=1) for axis in (0, 1))
    grid[i, j] = nodes
    return None if (grid < 0).any() else (axes, grid)


def _lines(values: Array) -> Array:
    """Increasing values that differ from the one before by more than round-off."""
    ordered = np.sort(values)
    # Nodes so near a line of the grid, over its extent, lie on it.
    return ordered[np.diff(ordered, prepend=-np.inf) > 1e-6 * float(np.ptp(ordered))]


def as_grid(source: MeshSource, grip_stiffness_N_per_mm3: float | None) -> OwnGrid | None:
    """The geometry that uses the elements of a mesh file unchanged; None unless their contact surface is a grid, see
    `grid_of`.

    grip_stiffness_N_per_mm3: stiffness of the grip per area; None if it is rigid.
    """
    patch = grid_of(source)
    if patch is None:
        return None
    solid = own_surface(source).solid
    axial, transverse = (GivenAxis(tuple(lines.tolist())) for lines in (patch.axial_mm, patch.transverse_mm))
    middle = patch.nodes[patch.shape[0] // 2, patch.shape[1] // 2]
    first, second = _layers_under(solid, int(middle))
    layering = Layering(growth=second / first, first=first / min(axial.finest_mm, transverse.finest_mm))
    return OwnGrid(source, axial, transverse, float(solid.edges_mm.max()), grip_stiffness_N_per_mm3, layering)


def _layers_under(solid: SolidMesh, node: int) -> tuple[float, float]:
    """Thicknesses in mm of the two uppermost layers of elements under a node of the contact."""
    found = []
    for _ in range(2):
        cells = solid.cells[8][(solid.cells[8] == node).any(axis=1)]
        others = np.setdiff1d(np.unique(cells), node)
        below = others[solid.points[others, 2] < solid.points[node, 2]]
        aside = np.linalg.norm(solid.points[below, :2] - solid.points[node, :2], axis=1)
        under = int(below[np.argmin(aside)])
        found.append(float(solid.points[node, 2] - solid.points[under, 2]))
        node = under
    return found[0], found[1]
