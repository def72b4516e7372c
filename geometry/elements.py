"""Shape functions, faces and integration points of the quadrilateral and of the solid elements that mesh files hold.

Nodes are numbered as in Abaqus and VTK: corners first, then the middles of edges, of faces, and of the element. The
reference hexahedron is [-1, 1]³, the tetrahedron has its corners at the origin and on the axes, the prism is the
triangle on the axes times [-1, 1]. Points in them are called reference points. Shape functions are polynomials that are
1 at their node and 0 at the others.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from geometry.arrays import Array, IntArray

#: Points and weights on the reference triangle that integrate polynomials of degree 2 and 4 (Dunavant 1985).
_TRIANGLE = {
    2: (np.array([[1 / 6, 1 / 6], [2 / 3, 1 / 6], [1 / 6, 2 / 3]]), np.full(3, 1 / 6)),
    4: (
        np.array(
            [
                [0.445948490915965, 0.445948490915965],
                [0.108103018168070, 0.445948490915965],
                [0.445948490915965, 0.108103018168070],
                [0.091576213509771, 0.091576213509771],
                [0.816847572980459, 0.091576213509771],
                [0.091576213509771, 0.816847572980459],
            ]
        ),
        np.repeat([0.111690794839005, 0.054975871827661], 3),
    ),
}
_IN_TETRAHEDRON = 0.25 - 0.05 * np.sqrt(5.0)  #: Coordinate of the four points that integrate degree 2 exactly.


@dataclass(frozen=True, eq=False)
class ElementKind:
    """A kind of element with n nodes and q integration points in d reference coordinates: 3, or 2 if quadrilateral."""

    name: str
    corners: int  #: Number of corners: the first nodes.
    nodes: Array  #: (n, d) in the reference element.
    exponents: IntArray  #: (n, d) exponents of the monomials that make up the shape functions.
    faces: tuple[tuple[int, ...], ...]  #: Corners of each face, ordered so that it faces outwards.
    points: Array  #: (q, d) integration points in the reference element.
    weights: Array  #: (q,) integration weights.

    @cached_property
    def face_nodes(self) -> tuple[IntArray, ...]:
        """For each face, the indices (m,) of all its m nodes, corners first."""
        found = []
        for face in self.faces:
            a, b, c = self.nodes[list(face[:3])]
            beside = (self.nodes - a) @ np.cross(b - a, c - a)
            others = np.setdiff1d(np.flatnonzero(np.abs(beside) < 1e-9), face)
            found.append(np.concatenate([np.array(face), others]))
        return tuple(found)

    def shapes(self, at: Array) -> Array:
        """Values (..., n) of the shape functions at reference points (..., d)."""
        return self._monomials(at, self.exponents) @ self._coefficients

    def slopes(self, at: Array) -> Array:
        """Derivatives (..., n, d) of the shape functions by reference coordinates, at reference points (..., d)."""
        found = []
        for axis in range(self.nodes.shape[1]):
            lower = self.exponents.copy()
            lower[:, axis] = np.maximum(lower[:, axis] - 1, 0)
            found.append((self._monomials(at, lower) * self.exponents[:, axis]) @ self._coefficients)
        return np.stack(found, axis=-1)

    def outside(self, at: Array) -> Array:
        """Distance (...) of reference points (..., 3) out of the element, in reference coordinates; <= 0 inside it."""
        if self.corners == 8:
            return np.asarray(np.abs(at).max(axis=-1) - 1.0)
        least = np.minimum(at[..., 0], at[..., 1])
        if self.corners == 4:
            return np.asarray(np.maximum(at.sum(axis=-1) - 1.0, -np.minimum(least, at[..., 2])))
        return np.asarray(np.maximum(np.maximum(at[..., 0] + at[..., 1] - 1.0, -least), np.abs(at[..., 2]) - 1.0))

    def within(self, at: Array) -> Array:
        """Reference points (..., 3), those outside the reference element moved to a point of its boundary."""
        if self.corners == 8:
            return np.clip(at, -1.0, 1.0)
        span = at if self.corners == 4 else at[..., :2]
        span = np.maximum(span, 0.0)
        span = span / np.maximum(span.sum(axis=-1, keepdims=True), 1.0)
        return span if self.corners == 4 else np.concatenate([span, np.clip(at[..., 2:], -1.0, 1.0)], axis=-1)

    @cached_property
    def middle(self) -> Array:
        """(d,) mean of the reference element's corners."""
        return np.asarray(self.nodes[: self.corners].mean(axis=0))

    @cached_property
    def _coefficients(self) -> Array:
        return np.asarray(np.linalg.inv(self._monomials(self.nodes, self.exponents)))

    @staticmethod
    def _monomials(at: Array, exponents: IntArray) -> Array:
        return np.asarray((at[..., None, :] ** exponents).prod(axis=-1))


def _with_middles(corners: Array, edges: list[tuple[int, int]]) -> Array:
    return np.vstack([corners, *(0.5 * (corners[[a]] + corners[[b]]) for a, b in edges)])


def _line(count: int) -> tuple[Array, Array]:
    abscissae, weights = np.polynomial.legendre.leggauss(count)
    return np.asarray(abscissae), np.asarray(weights)


def _hexahedra() -> list[ElementKind]:
    corners = np.array(
        [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]],
        dtype=float,
    )
    edges = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
    faces = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
    with_edges = _with_middles(corners, edges)
    middles = np.array([[0, 0, -1], [0, 0, 1], [0, -1, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, 0, 0]], dtype=float)
    powers = [np.array(one) for one in product(range(3), repeat=3)]
    kinds = []
    # A serendipity element has no more than one square, and that of one coordinate.
    for name, nodes, kept, count in (
        ("hexahedron of 8 nodes", corners, [p for p in powers if p.max() < 2], 2),
        ("hexahedron of 20 nodes", with_edges, [p for p in powers if (p == 2).sum() < 2], 3),
        ("hexahedron of 27 nodes", np.vstack([with_edges, middles]), powers, 3),
    ):
        x, w = _line(count)
        points, weights = np.array(list(product(x, repeat=3))), np.array(list(product(w, repeat=3))).prod(axis=1)
        kinds.append(ElementKind(name, 8, nodes, np.array(kept), faces, points, weights))
    return kinds


def _tetrahedra() -> list[ElementKind]:
    corners = np.vstack([np.zeros(3), np.eye(3)])
    edges = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
    faces = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
    a = _IN_TETRAHEDRON
    points, weights = np.full((4, 3), a) + (1.0 - 4.0 * a) * corners, np.full(4, 1 / 24)
    powers = [np.array(one) for one in product(range(3), repeat=3)]
    return [
        ElementKind(name, 4, nodes, np.array([p for p in powers if p.sum() <= degree]), faces, points, weights)
        for name, nodes, degree in (
            ("tetrahedron of 4 nodes", corners, 1),
            ("tetrahedron of 10 nodes", _with_middles(corners, edges), 2),
        )
    ]


def _prisms() -> list[ElementKind]:
    corners = np.array([[0, 0, -1], [1, 0, -1], [0, 1, -1], [0, 0, 1], [1, 0, 1], [0, 1, 1]], dtype=float)
    edges = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]
    faces = ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))
    with_edges = _with_middles(corners, edges)
    middles = _with_middles(corners, edges[:3])[-3:] + np.array([0.0, 0.0, 1.0])
    powers = [p for p in map(np.array, product(range(3), repeat=3)) if p[:2].sum() <= 2]
    kinds = []
    for name, nodes, kept, degree, count in (
        ("prism of 6 nodes", corners, [p for p in powers if p[:2].sum() < 2 and p[2] < 2], 2, 2),
        ("prism of 15 nodes", with_edges, [p for p in powers if p[2] < 2 or p[:2].sum() < 2], 4, 3),
        ("prism of 18 nodes", np.vstack([with_edges, middles]), powers, 4, 3),
    ):
        (plane, share), (z, w) = _TRIANGLE[degree], _line(count)
        points = np.array([[*at, height] for at in plane for height in z])
        kinds.append(ElementKind(name, 6, nodes, np.array(kept), faces, points, np.outer(share, w).ravel()))
    return kinds


#: Solid ones by the number of nodes, of which no two have as many.
ELEMENT_KINDS: dict[int, ElementKind] = {len(kind.nodes): kind for kind in (*_hexahedra(), *_tetrahedra(), *_prisms())}
BRICK = ELEMENT_KINDS[8]

#: Of four nodes, [-1, 1]² in reference coordinates.
QUADRILATERAL = ElementKind(
    "quadrilateral of 4 nodes",
    4,
    BRICK.nodes[:4, :2],
    np.array(list(product(range(2), repeat=2))),
    ((0, 1), (1, 2), (2, 3), (3, 0)),
    BRICK.nodes[:4, :2] / np.sqrt(3.0),
    np.ones(4),
)
