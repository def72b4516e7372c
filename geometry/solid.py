"""Meshes of solid elements from files: mixtures of element kinds, named sets, checks, and points located in them.

n is the number of nodes. Cells are numbered kind after kind, in the order of `SolidMesh.groups`; `size` of them. A
host is the elements of a file around a block of hexahedra made by this program; see `embedded`.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Self

import numpy as np
from scipy.sparse import coo_matrix

from geometry.arrays import Array, BoolArray, IntArray
from geometry.elements import ELEMENT_KINDS, ElementKind
from geometry.errors import GeometryError

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

LEAST_SHAPE = 0.01  #: Least determinant at a point of the Jacobian of an element, over its columns' lengths.
_TRIED, _NEWTON, _BESIDE = (
    24,
    8,
    3.0,
)  #: Cells tried for a place; Newton steps to its reference coordinates; their limit.
_CHUNK = 2_000_000  #: Numbers of places times cells that are looked at together.
_ON_A_FACE = 1e-3  #: Distance of a node from a cell, over the cell's size, from which on it is not on its face.


@dataclass(frozen=True)
class Places:
    """The places of p points in a mesh: the cell of each, and what interpolates nodal fields there."""

    cell: IntArray  #: (p,) number of the cell.
    #: For each kind of element with k nodes: indices (r,) of its points, nodes (r, k) of their cells, and values (r, k)
    #: of shape functions.
    weights: tuple[tuple[IntArray, IntArray, Array], ...]
    beyond_mm: Array  #: (p,) distance of the point outside its cell, 0 inside.


@dataclass(frozen=True, eq=False)
class _Faces:
    """Corners (f, c) of faces, by how many cells each is shared, and True where these give it other nodes."""

    corners: IntArray
    times: IntArray
    differ: BoolArray


@dataclass(frozen=True, eq=False)
class SolidMesh:
    """A mesh of n nodes and solid elements of any kinds, with named sets; lengths in mm."""

    points: Array  #: (n, 3).
    cells: Mapping[int, IntArray]  #: For each number of nodes k, the key in `ELEMENT_KINDS`, nodes (m, k) of its cells.
    sets: Mapping[str, IntArray]  #: Named sets of nodes, sorted indices; for a set of cells all their nodes.
    parts: Mapping[str, Mapping[int, BoolArray]]  #: Named sets of cells: for each k, (m,) True for its cells.

    @property
    def groups(self) -> Iterator[tuple[ElementKind, IntArray]]:
        return ((ELEMENT_KINDS[count], cells) for count, cells in self.cells.items())

    @property
    def size(self) -> int:
        return sum(len(cells) for cells in self.cells.values())

    def moved(self, points: Array) -> Self:
        return replace(self, points=points)

    @cached_property
    def boundary(self) -> tuple[IntArray, ...]:
        """Corners of faces that belong to one cell only, facing outwards: triangles (f, 3), quadrilaterals (f, 4)."""
        return tuple(each.corners[each.times == 1] for each in self._faces)

    @cached_property
    def _faces(self) -> tuple["_Faces", ...]:
        """Faces of all cells, equal ones once: triangles and quadrilaterals."""
        found: dict[int, list[tuple[IntArray, int]]] = {3: [], 4: []}
        for kind, cells in self.groups:
            for face, nodes in zip(kind.faces, kind.face_nodes, strict=True):
                found[len(face)].append((cells[:, list(face)], len(nodes)))
        made = []
        for count, lists in found.items():
            faces = np.vstack([np.zeros((0, count), dtype=np.int64), *(each for each, _ in lists)])
            nodes = np.repeat([n for _, n in lists], [len(each) for each, _ in lists]).astype(np.int64)
            _, first, which, times = np.unique(
                np.sort(faces, axis=1), axis=0, return_index=True, return_inverse=True, return_counts=True
            )
            differ = np.zeros(len(first), dtype=bool)
            differ[which.ravel()[nodes != nodes[first][which.ravel()]]] = True
            made.append(_Faces(faces[first], times, differ))
        return tuple(made)

    def nodes_between(self, corners: IntArray) -> IntArray:
        """Sorted nodes (k,) of those boundary faces whose corners are all among the nodes `corners`, nodes within edges
        and faces included.
        """
        known = np.zeros(len(self.points), dtype=bool)
        known[corners] = True
        faces = [each[known[each].all(axis=1)] for each in self.boundary]
        outer = {tuple(face) for each in faces for face in np.sort(each, axis=1).tolist()}
        found = np.zeros(len(self.points), dtype=bool)
        for kind, cells in self.groups:
            for face, nodes in zip(kind.faces, kind.face_nodes, strict=True):
                candidates = cells[known[cells[:, list(face)]].all(axis=1)]
                keys = np.sort(candidates[:, list(face)], axis=1).tolist()
                found[candidates[[tuple(key) in outer for key in keys]][:, nodes]] = True
        return np.flatnonzero(found)

    def faces_of(self, name: str) -> tuple[IntArray, ...]:
        """Boundary faces all of whose corners are in a named set: triangles (f, 3) and quadrilaterals (f, 4)."""
        inside = np.zeros(len(self.points), dtype=bool)
        inside[self.sets[name]] = True
        return tuple(faces[inside[faces].all(axis=1)] for faces in self.boundary)

    def triangles_of(self, name: str) -> IntArray:
        """Boundary faces all of whose corners are in a named set, as triangles (t, 3); quadrilaterals are split."""
        triangles, quads = self.faces_of(name)
        return np.vstack([triangles, quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])

    def areas_of(self, name: str) -> Array:
        """(n,) area in mm² that belongs to each node, of the boundary faces of a named set; 0 for others."""
        triangles = self.triangles_of(name)
        a, b, c = (self.points[triangles[:, k]] for k in range(3))
        size = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
        return np.bincount(triangles.ravel(), np.repeat(size / 3.0, 3), len(self.points)).astype(np.float64)

    @cached_property
    def edges_mm(self) -> Array:
        """(size,) size of each cell: mean distance between successive corners."""
        found = []
        for kind, cells in self.groups:
            at = self.points[cells[:, : kind.corners]]
            found.append(np.linalg.norm(np.diff(at, axis=1), axis=2).mean(axis=1))
        return np.concatenate(found)

    @cached_property
    def middles(self) -> Array:
        """(size, 3) mean of each cell's corners."""
        return np.vstack([self.points[cells[:, : kind.corners]].mean(axis=1) for kind, cells in self.groups])

    def gradients(self, kind: ElementKind, cells: IntArray) -> tuple[Array, Array]:
        """Gradients (m, q, k, 3) of the shape functions in 1/mm at the integration points of cells (m, k) of a kind,
        and the volume (m, q) in mm³ of each point.
        """
        slopes = kind.slopes(kind.points)
        jacobian = np.einsum("mni,qnj->mqij", self.points[cells], slopes, optimize=True)
        local = slopes @ np.linalg.inv(jacobian)
        return local, np.linalg.det(jacobian) * kind.weights

    def require_sound(self) -> None:
        """Raise GeometryError if a cell is inside out or has no volume, naming its place, if cells overlap or do not
        share whole faces of one order, or if nodes coincide or parts share none.

        That the boundary is closed need not be checked: it is the boundary of the cells.
        """
        for kind, cells in self.groups:
            jacobian = np.einsum("mni,qnj->mqij", self.points[cells], kind.slopes(kind.points), optimize=True)
            at = self.points[cells[:, : kind.corners]]
            lengths = np.linalg.norm(jacobian, axis=2).prod(axis=2)
            shape = (np.linalg.det(jacobian) / np.maximum(lengths, 1e-300)).min(axis=1)
            bad = np.flatnonzero(~(shape >= LEAST_SHAPE))
            if len(bad):
                worst = int(bad[np.argmin(shape[bad])])
                place = ", ".join(f"{x:.4g}" for x in at[worst].mean(axis=0))
                what = "turned inside out" if shape[worst] < -LEAST_SHAPE else "without volume"
                raise GeometryError(
                    f"{len(bad)} of its {len(cells)} elements ({kind.name}) are {what} or nearly flat, the worst at "
                    f"({place}) mm: number nodes as the format says, and mesh it again without slivers"
                )
        count, sizes = self._loose_parts()
        if count > 1:
            raise GeometryError(
                f"it consists of {count} parts that share no nodes, of {', '.join(map(str, sizes[:4]))}"
                f"{' …' if count > 4 else ''} nodes: merge coincident nodes, or leave all but one part out"
            )
        for faces in self._faces:
            self._refuse(faces.corners[faces.times > 2], "belong to three elements or more: list each element once")
            self._refuse(
                faces.corners[faces.differ],
                "have nodes between their corners on one side only, and would gape there: mesh it in one order",
            )
        pairs = self._tree_of(self.points).query_pairs(
            1e-7 * float(np.ptp(self.points, axis=0).max()), output_type="ndarray"
        )
        if len(pairs):
            place = ", ".join(f"{x:.4g}" for x in self.points[pairs[0, 0]])
            raise GeometryError(
                f"{2 * len(pairs)} of its nodes coincide in pairs, the first at ({place}) mm: merge them"
            )
        hanging = self._hanging()
        if len(hanging):
            place = ", ".join(f"{x:.4g}" for x in self.points[hanging[0]])
            raise GeometryError(
                f"{len(hanging)} of its nodes lie in or on the faces of elements that do not have them, the first at "
                f"({place}) mm: mesh it so that neighbours share whole faces"
            )
        triangles, quads = self.boundary
        cut = {tuple(sorted(face)) for face in triangles.tolist()}
        parts = [np.sort(np.delete(quads, corner, axis=1), axis=1).tolist() for corner in range(4)]
        halved = [any(tuple(part) in cut for part in each) for each in zip(*parts, strict=True)]
        self._refuse(quads[halved], "have two triangles on their other side, and would gape there: mesh it with prisms")

    def _hanging(self) -> IntArray:
        """Nodes that lie in or on a cell which does not have them, where cells have faces that are not shared."""
        outer = np.unique(np.concatenate([faces.ravel() for faces in self.boundary]))
        known = np.zeros(len(self.points), dtype=bool)
        known[outer] = True
        # A cell with a face of its own has three such corners at least.
        open_cells = [(kind, cells[known[cells[:, : kind.corners]].sum(axis=1) >= 3]) for kind, cells in self.groups]
        nodes = np.unique(np.concatenate([cells.ravel() for _, cells in open_cells]))
        tree, found = self._tree_of(self.points[nodes]), [np.zeros(0, dtype=np.int64)]
        for kind, cells in open_cells:
            low, high = self.points[cells].min(axis=1), self.points[cells].max(axis=1)
            margin = _ON_A_FACE * (high - low).max(axis=1, keepdims=True)
            low, high = low - margin, high + margin
            for part in np.array_split(np.arange(len(cells)), 1 + len(cells) // 5_000):
                near = tree.query_ball_point(0.5 * (low + high)[part], 0.5 * np.linalg.norm((high - low)[part], axis=1))
                cell = np.repeat(part, [len(each) for each in near])
                node = nodes[np.concatenate([np.array(each, dtype=np.int64) for each in near])]
                at = self.points[node]
                inside = ((at >= low[cell]) & (at <= high[cell])).all(axis=1) & (cells[cell] != node[:, None]).all(
                    axis=1
                )
                cell, node, at = cell[inside], node[inside], at[inside]
                local = self._local(kind, cells[cell], at)
                missed = np.einsum("pn,pni->pi", kind.shapes(local), self.points[cells[cell]]) - at
                touched = kind.outside(local) < _ON_A_FACE
                found.append(node[touched & (np.linalg.norm(missed, axis=1) < margin[cell, 0])])
        return np.unique(np.concatenate(found))

    def _refuse(self, faces: IntArray, why: str) -> None:
        if len(faces):
            place = ", ".join(f"{x:.4g}" for x in self.points[faces[0]].mean(axis=0))
            raise GeometryError(f"faces of its elements, {len(faces)} in all, the first at ({place}) mm, {why}")

    def _loose_parts(self) -> tuple[int, list[int]]:
        from scipy.sparse.csgraph import connected_components

        rows = np.concatenate([cells[:, :1].repeat(cells.shape[1], axis=1).ravel() for cells in self.cells.values()])
        columns = np.concatenate([cells.ravel() for cells in self.cells.values()])
        size = len(self.points)
        graph = coo_matrix((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=(size, size))
        _, label = connected_components(graph, directed=False)
        sizes = np.bincount(label[np.unique(columns)])
        sizes = np.sort(sizes[sizes > 0])[::-1]
        return len(sizes), sizes.tolist()

    def located(self, places: Array) -> Places:
        """The places in the mesh of points (p, 3) in mm: each gets the cell that contains it, or else the nearest of
        those tried.
        """
        cell, best, local = (
            np.zeros(len(places), dtype=np.int64),
            np.full(len(places), np.inf),
            np.zeros((len(places), 3)),
        )
        kinds = list(self.groups)
        starts = np.cumsum([0, *(len(cells) for _, cells in kinds)])
        near = np.asarray(self._tree.query(places, k=min(_TRIED, self.size))[1]).reshape(len(places), -1)
        pairs = np.column_stack([np.repeat(np.arange(len(places)), near.shape[1]), near.ravel()])
        low, high = self._boxes
        # A cell that is tried has the place in its box, or so little beside it.
        margin = 0.1 * (high - low).max(axis=1, keepdims=True)
        at = places[pairs[:, 0]]
        held = (at >= (low - margin)[pairs[:, 1]]).all(axis=1) & (at <= (high + margin)[pairs[:, 1]]).all(axis=1)
        pairs = pairs[held]
        for search in range(2):
            for (kind, cells), first in zip(kinds, starts, strict=False):
                own = pairs[(pairs[:, 1] >= first) & (pairs[:, 1] < first + len(cells))]
                for part in np.array_split(own, max(1, len(own) * cells.shape[1] // _CHUNK)):
                    nodes, wanted = cells[part[:, 1] - first], places[part[:, 0]]
                    at = self._local(kind, nodes, wanted)
                    nearest = np.einsum("pn,pni->pi", kind.shapes(kind.within(at)), self.points[nodes])
                    beyond = np.linalg.norm(nearest - wanted, axis=1) * (kind.outside(at) > 0.0)
                    _keep_best(part, beyond, at, cell, best, local)
            if search == 0:
                # A place so little beyond a cell, over the cell's size, is taken to lie in it.
                pairs = self._boxed(places, np.flatnonzero(best > 1e-3 * self.edges_mm[cell]))
        shapes = []
        for (kind, cells), first in zip(kinds, starts, strict=False):
            rows = np.flatnonzero((cell >= first) & (cell < first + len(cells)))
            shapes.append((rows, cells[cell[rows] - first], kind.shapes(local[rows])))
        return Places(cell, tuple(shapes), best)

    @staticmethod
    def _tree_of(places: Array) -> "cKDTree":
        from scipy.spatial import cKDTree

        return cKDTree(places)

    @cached_property
    def _tree(self) -> "cKDTree":
        return self._tree_of(self.middles)

    def _boxed(self, places: Array, which: IntArray) -> IntArray:
        """Pairs (k, 2) of a place, among `which`, and a cell whose bounding box contains it; also each place and its
        nearest cell.
        """
        low, high = self._boxes
        found = [np.zeros((0, 2), dtype=np.int64)]
        for part in np.array_split(which, max(1, len(which) * self.size // _CHUNK)):
            at = places[part][:, None]
            row, column = np.nonzero(((at >= low) & (at <= high)).all(axis=2))
            found.append(np.column_stack([part[row], column]))
        if len(which):
            found.append(np.column_stack([which, self._tree.query(places[which])[1]]))
        return np.vstack(found)

    @cached_property
    def _boxes(self) -> tuple[Array, Array]:
        """Lower and upper corners (size, 3) of the cells' bounding boxes."""
        low = np.vstack([self.points[cells].min(axis=1) for cells in self.cells.values()])
        high = np.vstack([self.points[cells].max(axis=1) for cells in self.cells.values()])
        return low, high

    def _local(self, kind: ElementKind, cells: IntArray, places: Array) -> Array:
        """Reference coordinates (p, 3) of places in one cell each, (p, k)."""
        nodes = self.points[cells]
        local = np.tile(kind.middle, (len(places), 1))
        for _ in range(1 if len(kind.nodes) == 4 else _NEWTON):
            missed = places - np.einsum("pn,pni->pi", kind.shapes(local), nodes)
            jacobian = np.einsum("pni,pnj->pij", nodes, kind.slopes(local))
            step = np.linalg.solve(jacobian, missed[..., None])[..., 0]
            local = local + step if len(kind.nodes) == 4 else np.clip(local + step, -_BESIDE, _BESIDE)
        return local


def _keep_best(pairs: IntArray, beyond: Array, local: Array, cell: IntArray, best: Array, at: Array) -> None:
    """Update for each place the best cell, its distance and reference coordinates, in place; at: the coordinates."""
    order = np.argsort(beyond)[::-1]
    better = order[beyond[order] < best[pairs[order, 0]]]
    rows = pairs[better, 0]
    # Of several for one place the last assignment, the best one, holds.
    best[rows], cell[rows], at[rows] = beyond[better], pairs[better, 1], local[better]


@dataclass(frozen=True, eq=False)
class BlockSeam:
    """Where block and host are joined: f faces of the block's sides and back, with q integration points each."""

    cells: IntArray  #: (f,) cell of the block at each face.
    local: Array  #: (f, q, 3) integration points in the cells' reference coordinates.
    areas_mm2: Array  #: (f, q, 3) area of each point times the block's outward unit normal.
    depth_mm: Array  #: (f,) thickness of the block's cells at the faces.
    places: Places  #: Places of the f q points in the host.


@dataclass(frozen=True, eq=False)
class Host:
    """The elements of a file around a block, in the body's axes; n nodes and `size` cells."""

    solid: SolidMesh  #: All of the file's elements, those inside the block included.
    kept: Array  #: (size,) share of each cell, 0 to 1, that lies outside the block and counts.
    seam: BlockSeam
    held: IntArray  #: Indices of the host's nodes that the holder grips.
    areas_mm2: Array  #: (n,) area of the grip that belongs to each node of the host.
    part: IntArray  #: (size,) number of each cell's material in `parts`, from 1; 0 for the body's own.
    block_part: IntArray  #: (m, q) likewise, at the integration points of the block's cells.
    parts: tuple[tuple[float, float], ...]  #: (Young's modulus in MPa, Poisson's ratio) of each further material.
