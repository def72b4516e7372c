"""The compliance of a body at its contact patch, stored by mirror symmetry, and a correction of it near loaded nodes.

Symmetry: a body that is its own mirror image about a plane responds to forces that are even about the plane with even
displacements, and to odd ones with odd displacements. Either belongs to the piece on one side alone, held on the plane
accordingly: there the displacement normal to the plane is zero if it is even, that within the plane if it is odd. With
two such planes the matrix is stored as four of a quarter of the size each (Glockner, J. Struct. Div. ASCE 99 (1973)
71).

Near-field correction: close to the contact both bodies act as half-spaces. The elements of the body that carries the
tractions give half as much again as it should where one node is pressed, and those of the other, which sees the
tractions spread by the mortar, too little. Right is the mean displacement of the node's cell under uniform traction on
it. The difference is computed wave by wave: a lattice of equal bricks responds to a wave of nodal forces with a wave,
layer below layer, and a half-space does so in closed form (Johnson, Contact Mechanics, 1985, sections 3.2 and 3.6,
transformed). It fades within a few elements, since bricks resolve long waves. A wave is given by the angles in rad by
which its phase turns from node to node along and across. Displacements and forces are (..., 3): x, y, and z outwards.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import product

import numpy as np

from geometry import Elastic, HexMesh
from geometry.arrays import Array, ComplexArray, IntArray
from geometry.elements import BRICK
from solvers.elasticity.linear_elasticity import integration_points
from solvers.jit_cache import compiled

Pair = tuple[float, float]

_DEPTH, _WAVES = 24.0, 2.0  #: How deep the lattice reaches at least, in elements and in longest waves.
#: Corners of a brick along each axis, in the order of its nodes; the first four are below.
_CORNERS = (BRICK.nodes + 1.0) / 2.0

_ONE, _TWO = np.uint64(1), np.uint64(2)  # Of the type that indices have in the innermost loop.


@dataclass(frozen=True)
class Bricks:
    """The elements under a contact patch: their material and the thickness of their layers."""

    material: Elastic
    layers: Pair  #: Thickness of the uppermost layer in mm, and its growth factor from layer to layer downwards.


def reach(size_mm: Pair) -> tuple[int, int]:
    """How many elements (along, across) of the size (along, across) in mm a near-field correction reaches."""
    along, across = (int(np.ceil(6.0 * max(size_mm) / each)) for each in size_mm)
    return along, across


@lru_cache(maxsize=256)
def missing_displacement(own: Bricks, own_mm: Pair, other: Bricks, other_mm: Pair, turn: tuple[Pair, Pair]) -> Array:
    """Correction, in mm/N, of the displacements of both bodies together around a loaded node of the first body.

    own, own_mm: elements and their size (along, across) in mm of the first body, which carries the tractions; other,
    other_mm: of the body that faces it. turn: (2, 2) from the first body's plane axes to the other's. Returns (2 a + 1,
    2 t + 1, 3, 3) for the nodes up to `reach` = (a, t) lines away, by component of displacement and of force, in the
    first body's axes: the mean over all positions of one lattice relative to the other.
    """
    counts = tuple(2 * each + 1 for each in reach(own_mm))
    # Opposite waves have conjugate answers: half of them are enough.
    halves = 2.0 * np.pi * np.fft.fftfreq(counts[0]), 2.0 * np.pi * np.fft.rfftfreq(counts[1])
    along, across = (each.ravel() for each in np.meshgrid(*halves, indexing="ij"))
    lacking = _of_cells(along, across, own_mm, own.material) - _of_bricks(along, across, own_mm, own)
    to_other = np.zeros((3, 3))
    to_other[:2, :2], to_other[2, 2] = turn, -1.0
    lacking += to_other.T @ _lacking_in_other(along, across, own_mm, other, other_mm, to_other) @ to_other
    lacking[0] = 0.0
    found = np.fft.irfft2(lacking.reshape(counts[0], -1, 3, 3), counts, axes=(0, 1))
    return np.asarray(np.fft.fftshift(found, axes=(0, 1)))


def half_space_response(kx: Array, ky: Array, material: Elastic) -> ComplexArray:
    """Surface displacement (n, 3, 3) in mm/MPa of a half-space, by component, under waves of traction of unit
    amplitude.

    kx, ky: (n,) wave numbers in 1/mm; the response to wave number 0 is set to 0.
    """
    size = np.hypot(kx, ky)
    inverse = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0.0)
    n = np.stack([kx * inverse, ky * inverse])
    nu = material.poissons_ratio
    result = np.zeros((len(kx), 3, 3), dtype=np.complex128)
    for i in range(2):
        for j in range(2):
            result[:, i, j] = 2.0 * inverse * ((i == j) - nu * n[i] * n[j])
        result[:, 2, i] = 1j * (1.0 - 2.0 * nu) * inverse * n[i]
        result[:, i, 2] = -result[:, 2, i]
    result[:, 2, 2] = 2.0 * (1.0 - nu) * inverse
    return np.asarray(result * ((1.0 + nu) / material.youngs_modulus_MPa))


def _aliases(along: Array, across: Array) -> Iterator[tuple[Array, Array, Array]]:
    """Waves that look alike at the nodes: angles (n,) along and across, and the share of each in the traction that is
    uniform on the nodes' cells.
    """
    # Shorter waves beneath those that a lattice resolves, which a cell's uniform traction contains.
    for m, n in product(range(-4, 5), repeat=2):
        x, y = along + 2.0 * np.pi * m, across + 2.0 * np.pi * n
        yield x, y, np.sinc(x / (2.0 * np.pi)) * np.sinc(y / (2.0 * np.pi))


def _of_cells(along: Array, across: Array, size: Pair, material: Elastic) -> ComplexArray:
    """Mean displacement of cells by waves of forces on cells, each spread evenly over its own cell, (n, 3, 3)
    in mm/N.
    """
    result = np.zeros((len(along), 3, 3), dtype=np.complex128)
    for x, y, cell in _aliases(along, across):
        result += (cell**2)[:, None, None] * half_space_response(x / size[0], y / size[1], material)
    return np.asarray(result / (size[0] * size[1]))


def _lacking_in_other(
    along: Array, across: Array, size: Pair, bricks: Bricks, other: Pair, to_other: Array
) -> ComplexArray:
    """Correction for the facing body's elements, (n, 3, 3) in mm/N in that body's axes: half-space less bricks.

    Its nodes are loaded through their hat functions, and its displacements averaged over the first body's cells.
    """
    result = np.zeros((len(along), 3, 3), dtype=np.complex128)
    seen: list[tuple[IntArray, Array, Array]] = []
    for x, y, cell in _aliases(along, across):
        k = to_other[:2, :2] @ np.stack([x / size[0], y / size[1]])
        result += (cell**2)[:, None, None] * half_space_response(k[0], k[1], bricks.material)
        angles = k * np.array(other)[:, None]
        share = (cell * np.sinc(angles[0] / (2.0 * np.pi)) * np.sinc(angles[1] / (2.0 * np.pi))) ** 4
        # What has a smaller share is left out.
        which = np.flatnonzero((share > 1e-3) & (np.hypot(*angles) > 0.0))
        seen.append((which, share[which] * other[0] * other[1], angles[:, which]))
    wave, weight, angles = (np.concatenate(parts, axis=-1) for parts in zip(*seen, strict=True))
    np.subtract.at(result, wave, weight[:, None, None] * _of_bricks(angles[0], angles[1], other, bricks))
    return np.asarray(result / (size[0] * size[1]))


def _of_bricks(along: Array, across: Array, size: Pair, bricks: Bricks) -> ComplexArray:
    """Displacement of surface nodes by waves of nodal forces of given angles (n,), (n, 3, 3) in mm/N; angles of 0 are
    excluded.
    """
    waves = np.exp(1j * (np.outer(along, _CORNERS[:4, 0]) + np.outer(across, _CORNERS[:4, 1])))
    phase = (waves.conj()[:, :, None] * waves[:, None, :]).reshape(-1, 16)
    thickness, growth = bricks.layers
    layers = [thickness]
    numbers = np.hypot(along / size[0], across / size[1])
    longest = 2.0 * np.pi / float(numbers[numbers > 0.0].min())
    while sum(layers) < max(_DEPTH * max(size), _WAVES * longest):
        layers.append(layers[-1] * growth)
    answer = np.zeros((len(along), 3, 3), dtype=np.complex128)
    for k, stiffness in enumerate(_between_sides(size, np.array(layers[::-1]), bricks.material)):
        below, rise, fall, above = (phase @ stiffness).reshape(len(along), 4, 3, 3).swapaxes(0, 1)
        # The lowest side is held.
        answer = above - fall @ np.linalg.solve(below + answer, rise) if k else above
    return np.asarray(np.linalg.inv(answer))


def _between_sides(size: Pair, thickness_mm: Array, material: Elastic) -> Array:
    """Stiffness (l, 16, 36) of l bricks of different thickness: for each pair of corners of one side, the force on a
    side (below or above) by the displacement of a side, by components.
    """
    count = len(thickness_mm)
    corners = _CORNERS * np.array([*size, 1.0]) * np.stack([np.ones(count), np.ones(count), thickness_mm], -1)[:, None]
    points = integration_points(HexMesh(corners.reshape(-1, 3), np.arange(8 * count).reshape(-1, 8), {}))
    unit = np.tile(np.eye(24).reshape(24, 1, 8, 3), (1, count, 1, 1)).reshape(24, -1, 3)
    columns = np.array([points.internal_forces(points.stresses(material, one)) for one in unit])
    # Axes: side, corner and component moved; layer; side, corner and component of the force.
    forces = columns.reshape(2, 4, 3, count, 2, 4, 3).transpose(3, 5, 1, 4, 0, 6, 2)
    return np.ascontiguousarray(forces.reshape(count, 16, 36))


@dataclass(frozen=True)
class PatchCompliance:
    """Displacements of a patch's nodes by forces on them, in mm/N; unknown 3 i + k belongs to node i and axis k.

    With p mirror planes the patch consists of 2^p images of the piece of q nodes on the planes' non-negative sides.
    """

    shape: tuple[int, int]  #: (n_a, n_t) nodes of the patch.
    #: The patch's axes, 0 along the body and 1 across it, about whose zero the body is its own mirror image.
    planes: tuple[int, ...]
    #: (2^p, 3 q, 3 q) mm/N: how the q nodes on the planes' non-negative sides, in the patch's order, move by forces on
    #: themselves, and by forces on their mirror images, these forces reflected as their nodes are. The last plane is
    #: the first to change. Each is symmetric.
    blocks: Array
    #: (3, 3) turns vectors from the body's axes, in which its planes are given, to those of forces and displacements.
    rotation: Array = field(default_factory=lambda: np.eye(3))

    @classmethod
    def of_parities(cls, shape: tuple[int, int], planes: tuple[int, ...], parts: Array) -> "PatchCompliance":
        """From the compliances (2^p, 3 q, 3 q) in mm/N of the piece under even and odd forces; `parts` is overwritten.

        Their order: even about each plane before odd, the last plane changing first. Nodes on a plane carry the piece's
        half of the forces there; unknowns held on a plane have a compliance of zero.
        """
        kinds = parts.reshape(*(2,) * len(planes), *parts.shape[1:])
        for axis in range(len(planes)):
            even, odd = np.moveaxis(kinds, axis, 0)
            # A force on one side is half its even and half its odd part.
            even += odd
            even *= 0.5
            np.subtract(even, odd, out=odd)
        return cls(shape, planes, parts)

    def turned(self, rotation: Array) -> "PatchCompliance":
        if np.array_equal(rotation, np.eye(3)):
            return self
        triples = np.ascontiguousarray(self.blocks).reshape(-1, 3) @ rotation.T
        rows = triples.reshape(-1, 3, self.blocks.shape[-1])
        return replace(self, blocks=(rotation @ rows).reshape(self.blocks.shape), rotation=rotation @ self.rotation)

    def with_neighbours(self, near: Array, kind: IntArray, share: Array) -> "PatchCompliance":
        """This compliance plus corrections of the displacements around loaded nodes, up to (a, t) lines away.

        near: (m, 2 a + 1, 2 t + 1, 3, 3) displacement per force in mm/N in the body's axes, for m kinds of node, by the
        distance in lines from the loaded to the moved node. kind, share: (q,) the kind of each node of the piece and a
        factor on its correction. A pair of nodes gets the mean of the corrections of both, made symmetric as the body
        is.
        """
        for axis in self.planes:
            mirror = np.ones(3)
            mirror[axis] = -1.0
            near = 0.5 * (near + mirror[:, None] * np.flip(near, 1 + axis) * mirror)
        near = 0.5 * (near + near[:, ::-1, ::-1].swapaxes(-1, -2))
        turned = self.rotation @ near @ self.rotation.T @ self._reflections[:, None, None, None]
        blocks, piece = self.blocks.copy(), np.array(_piece(self.shape, self.planes))
        _add_near(blocks, piece, self.sides, np.ascontiguousarray(turned), kind, share)
        return replace(self, blocks=blocks)

    @property
    def sides(self) -> IntArray:
        """(2^p, 2) 1 where an image of the piece is reversed along an axis."""
        bits = [2 ** self.planes[::-1].index(axis) if axis in self.planes else 0 for axis in (0, 1)]
        return np.asarray((np.arange(len(self.blocks))[:, None] & bits) > 0, dtype=np.int64)

    def piece_nodes(self) -> IntArray:
        """Indices (q,) in the patch of the nodes on the non-negative sides of the planes, in the order of `blocks`."""
        lines = (np.arange(n)[n // 2 if axis in self.planes else 0 :] for axis, n in enumerate(self.shape))
        return np.asarray(
            np.add.outer(*(each * step for each, step in zip(lines, (self.shape[1], 1), strict=True)))
        ).ravel()

    def between(self, moved: IntArray, loaded: IntArray, out: Array | None = None, add: Array | None = None) -> Array:
        result = np.empty((3 * len(moved), 3 * len(loaded))) if out is None else out
        if self._signs is not None:
            forces = self._signs if add is None else self._signs * add
            _gather_mirrored(self.blocks, *self._places, self._signs, forces, moved, loaded, result, add is not None)
        elif add is not None:
            result += self.between(moved, loaded) * np.tile(add, len(loaded))
        else:
            _gather(self.blocks, *self._places, self._reflections, moved, loaded, result)
        return result

    @cached_property
    def dense(self) -> Array:
        everywhere = np.arange(self.shape[0] * self.shape[1])
        return self.between(everywhere, everywhere)

    def diagonal(self) -> Array:
        side, place = self._places
        q = len(self.blocks[0]) // 3
        node = np.arange(q)
        own = self.blocks[0].reshape(q, 3, q, 3)[node, :, node, :]
        reflections = self._reflections[side]
        return np.asarray(np.einsum("nak,nkl,nla->na", reflections, own[place], reflections).ravel())

    @cached_property
    def _places(self) -> tuple[IntArray, IntArray]:
        """For each node (n,): which image of the piece it belongs to, and which node of the piece it is the
        image of.
        """
        places = [np.arange(n) for n in self.shape]
        sides = [np.zeros(n, dtype=np.int64) for n in self.shape]
        for k, axis in enumerate(self.planes):
            middle = self.shape[axis] // 2
            lines = np.arange(self.shape[axis]) - middle
            sides[axis] = np.where(lines < 0, 2 ** (len(self.planes) - 1 - k), 0)
            places[axis] = np.abs(lines)
        width = _piece(self.shape, self.planes)[1]
        return (sides[0][:, None] + sides[1]).ravel(), (places[0][:, None] * width + places[1]).ravel()

    @cached_property
    def _reflections(self) -> Array:
        """Matrices (2^p, 3, 3) that turn vectors of the piece into those of each image."""
        found = [np.eye(3)]
        for axis in self.planes:
            mirror = self.rotation @ np.diag(np.where(np.arange(3) == axis, -1.0, 1.0)) @ self.rotation.T
            found = [each for one in found for each in (one, one @ mirror)]
        return np.array(found)

    @cached_property
    def _signs(self) -> Array | None:
        """Signs (2^p, 3) of the components under each reflection; None unless reflections only change signs."""
        if (self._reflections * (1.0 - np.eye(3))).any():
            return None
        return np.ascontiguousarray(np.einsum("gkk->gk", self._reflections))


def _piece(shape: tuple[int, int], planes: tuple[int, ...]) -> tuple[int, int]:
    """Numbers of nodes (along, across) on the non-negative sides of the planes, the nodes on the planes included."""
    along, across = ((n + 1) // 2 if axis in planes else n for axis, n in enumerate(shape))
    return along, across


@compiled
def _add_near(blocks: Array, piece: IntArray, flips: IntArray, near: Array, kind: IntArray, share: Array) -> None:
    """Add corrections to `blocks` in place.

    flips: (2^p, 2) 1 where an image of the piece is reversed along an axis. near: (2^p, m, ...) for each image, forces
    reflected as it is. kind, share: (q,) as in `PatchCompliance.with_neighbours`.
    """
    rows, columns = near.shape[2] // 2, near.shape[3] // 2
    for image in range(len(blocks)):
        for i in range(piece[0] * piece[1]):
            own_a, own_t = i // piece[1], i % piece[1]
            # Of the nodes on lines near enough; the patch's middle line is its own image.
            for other_a in range(0 if flips[image, 0] else max(own_a - rows, 0), piece[0]):
                a = own_a + (other_a if flips[image, 0] else -other_a)
                if abs(a) > rows:
                    break
                for other_t in range(0 if flips[image, 1] else max(own_t - columns, 0), piece[1]):
                    t = own_t + (other_t if flips[image, 1] else -other_t)
                    if abs(t) > columns:
                        break
                    j = other_a * piece[1] + other_t
                    moved = near[image, kind[i], a + rows, t + columns]
                    loaded = near[image, kind[j], a + rows, t + columns]
                    for u in range(3):
                        for v in range(3):
                            blocks[image, 3 * i + u, 3 * j + v] += 0.5 * (
                                share[i] * moved[u, v] + share[j] * loaded[u, v]
                            )


@compiled
def _gather_mirrored(
    blocks: Array,
    side: IntArray,
    place: IntArray,
    signs: Array,
    forces: Array,
    moved: IntArray,
    loaded: IntArray,
    result: Array,
    add: bool,
) -> None:
    """Write to `result`, or with `add` add to it, displacements of the nodes `moved` by forces on `loaded`.

    signs, forces: (2^p, 3) factors on the components of displacement and of force for each image of the piece.
    """
    # Unsigned and known beforehand: this is a run's innermost loop.
    count = len(loaded)
    block, column = np.empty((len(blocks), count), dtype=np.uint64), np.empty(count, dtype=np.uint64)
    factors = np.empty((count, 3))
    for j in range(count):
        other = side[loaded[j]]
        for own in range(len(blocks)):
            block[own, j] = own ^ other
        column[j] = 3 * place[loaded[j]]
        for c in range(3):
            factors[j, c] = forces[other, c]
    for i in range(len(moved)):
        own, row = side[moved[i]], 3 * place[moved[i]]
        chosen = block[own]
        for a in range(3):
            sign, target = signs[own, a], result[3 * i + a]
            for j in range(count):
                source = blocks[chosen[j], row + a]
                x = sign * factors[j, 0] * source[column[j]]
                y = sign * factors[j, 1] * source[column[j] + _ONE]
                z = sign * factors[j, 2] * source[column[j] + _TWO]
                if add:
                    x, y, z = x + target[3 * j], y + target[3 * j + 1], z + target[3 * j + 2]
                target[3 * j], target[3 * j + 1], target[3 * j + 2] = x, y, z


@compiled
def _gather(
    blocks: Array, side: IntArray, place: IntArray, reflections: Array, moved: IntArray, loaded: IntArray, result: Array
) -> None:
    """Write displacements of the nodes `moved` by forces on `loaded` to `result`; reflections: (2^p, 3, 3) for each
    image.
    """
    half = np.empty((3, 3))
    for i in range(len(moved)):
        own, row = side[moved[i]], 3 * place[moved[i]]
        for j in range(len(loaded)):
            other, column = side[loaded[j]], 3 * place[loaded[j]]
            block = blocks[own ^ other]
            for a in range(3):
                for b in range(3):
                    total = 0.0
                    for c in range(3):
                        total += reflections[own, a, c] * block[row + c, column + b]
                    half[a, b] = total
            for a in range(3):
                for b in range(3):
                    total = 0.0
                    for c in range(3):
                        total += half[a, c] * reflections[other, c, b]
                    result[3 * i + a, 3 * j + b] = total
