"""The compliance of a body at its contact patch, kept by its mirror symmetries.

A body that is its own mirror image about a plane answers forces that are even about it with even displacements, odd
ones with odd ones. Each kind belongs to the piece on one side alone, held on the plane accordingly: its displacement
across the plane is zero there if it is even, that along the plane if it is odd. So a body with two such planes is four
times a quarter, a quarter of the numbers (Glockner, J. Struct. Div. ASCE 99 (1973) 71).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.errors import SolverError
from solvers.kept_code import compiled

# Of the type that indices have in the innermost loop.
_ONE, _TWO = np.uint64(1), np.uint64(2)


@dataclass(frozen=True)
class PatchCompliance:
    """Displacements of a patch's nodes by forces on them, in mm/N; unknown 3 i + k belongs to node i and axis k.

    shape: (n_a, n_t) nodes of the patch.
    planes: the patch's axes, 0 along the body and 1 across it, about whose zero the body is its own mirror image.
    blocks: (2^p, 3 q, 3 q) for p planes: how the q nodes on the planes' non-negative sides, in the patch's order, move
    by forces on themselves, and by forces on their mirror images, these forces reflected as their nodes are. The last
    plane is the first to change. Each is symmetric.
    rotation: (3, 3) from the body's axes, in which its planes are given, to those of forces and displacements.
    """

    shape: tuple[int, int]
    planes: tuple[int, ...]
    blocks: Array
    rotation: Array = field(default_factory=lambda: np.eye(3))

    def __post_init__(self) -> None:
        q = 3 * int(np.prod(_piece(self.shape, self.planes)))
        if self.blocks.shape != (2 ** len(self.planes), q, q):
            raise SolverError(
                f"a patch of {self.shape} nodes with mirror planes {self.planes} has no compliance of shape "
                f"{self.blocks.shape}"
            )

    @classmethod
    def of_parities(cls, shape: tuple[int, int], planes: tuple[int, ...], parts: Array) -> PatchCompliance:
        """From the compliances (2^p, 3 q, 3 q) of the piece on the planes' non-negative sides, which are used up.

        Even about each plane before odd, the last plane first to change. Nodes on a plane carry the piece's half of the
        forces there; what is held on a plane has compliance zero.
        """
        kinds = parts.reshape(*(2,) * len(planes), *parts.shape[1:])
        for axis in range(len(planes)):
            even, odd = np.moveaxis(kinds, axis, 0)
            # A force on one side is half its even and half its odd part.
            even += odd
            even *= 0.5
            np.subtract(even, odd, out=odd)
        return cls(shape, planes, parts)

    def turned(self, rotation: Array) -> PatchCompliance:
        """The same displacements in other axes, by a matrix (3, 3) that turns vectors into them."""
        if np.array_equal(rotation, np.eye(3)):
            return self
        triples = np.ascontiguousarray(self.blocks).reshape(-1, 3) @ rotation.T
        rows = triples.reshape(-1, 3, self.blocks.shape[-1])
        return replace(self, blocks=(rotation @ rows).reshape(self.blocks.shape), rotation=rotation @ self.rotation)

    def with_neighbours(self, near: Array, kind: IntArray, share: Array) -> PatchCompliance:
        """The same with displacements added of nodes by forces on nodes up to (a, t) lines away.

        near: (m, 2 a + 1, 2 t + 1, 3, 3) in the body's axes, of m kinds of node: by the lines from the loaded node to
        the moved one, which get the mean of what their kinds say.  kind, share: of the piece's nodes (q,), and what
        their kind's is multiplied by. What is added is made symmetric as the body is.
        """
        for axis in self.planes:
            mirror = np.ones(3)
            mirror[axis] = -1.0
            near = 0.5 * (near + mirror[:, None] * np.flip(near, 1 + axis) * mirror)
        near = 0.5 * (near + near[:, ::-1, ::-1].swapaxes(-1, -2))
        blocks = self.blocks.copy()
        flips = np.zeros((len(blocks), 2), dtype=np.int64)
        for k, axis in enumerate(reversed(self.planes)):
            flips[:, axis] = (np.arange(len(blocks)) >> k) & 1
        turned = self.rotation @ near @ self.rotation.T @ self._reflections[:, None, None, None]
        piece = np.array(_piece(self.shape, self.planes))
        _add_near(blocks, piece, flips, np.ascontiguousarray(turned), kind, share)
        return replace(self, blocks=blocks)

    def piece_nodes(self) -> IntArray:
        """The patch's nodes (q,) on the non-negative sides of the planes, to which `blocks` belong."""
        lines = (np.arange(n)[n // 2 if axis in self.planes else 0 :] for axis, n in enumerate(self.shape))
        return np.asarray(
            np.add.outer(*(each * step for each, step in zip(lines, (self.shape[1], 1), strict=True)))
        ).ravel()

    def between(self, moved: IntArray, loaded: IntArray, out: Array | None = None) -> Array:
        """Displacements of some nodes (k,) by unit forces on others (l,), (3 k, 3 l), written to `out` if given."""
        result = np.empty((3 * len(moved), 3 * len(loaded))) if out is None else out
        if self._signs is None:
            _gather(self.blocks, *self._places, self._reflections, moved, loaded, result)
        else:
            _gather_mirrored(self.blocks, *self._places, self._signs, moved, loaded, result)
        return result

    @cached_property
    def dense(self) -> Array:
        """The whole matrix (3 n, 3 n), put together when it is first asked for."""
        everywhere = np.arange(self.shape[0] * self.shape[1])
        return self.between(everywhere, everywhere)

    def diagonal(self) -> Array:
        """Displacement of each unknown by a unit force on itself, (3 n,)."""
        side, place = self._places
        q = len(self.blocks[0]) // 3
        node = np.arange(q)
        own = self.blocks[0].reshape(q, 3, q, 3)[node, :, node, :]
        reflections = self._reflections[side]
        return np.asarray(np.einsum("nak,nkl,nla->na", reflections, own[place], reflections).ravel())

    @cached_property
    def _places(self) -> tuple[IntArray, IntArray]:
        """Which image of the piece each node (n,) belongs to, and which of the piece's nodes it is the image of."""
        along, across = (np.arange(n) for n in self.shape)
        sides = [np.zeros(n, dtype=np.int64) for n in self.shape]
        for k, axis in enumerate(self.planes):
            middle = self.shape[axis] // 2
            lines = np.arange(self.shape[axis]) - middle
            sides[axis] = np.where(lines < 0, 2 ** (len(self.planes) - 1 - k), 0)
            if axis == 0:
                along = np.abs(lines)
            else:
                across = np.abs(lines)
        width = _piece(self.shape, self.planes)[1]
        return (sides[0][:, None] + sides[1]).ravel(), (along[:, None] * width + across).ravel()

    @cached_property
    def _reflections(self) -> Array:
        """Of vectors into each image of the piece, (2^p, 3, 3)."""
        found = [np.eye(3)]
        for axis in self.planes:
            found = [each for one in found for each in (one, one @ self._reflection(axis))]
        return np.array(found)

    @cached_property
    def _signs(self) -> Array | None:
        """What the reflections do to components, (2^p, 3), where they only change signs."""
        if (self._reflections * (1.0 - np.eye(3))).any():
            return None
        return np.ascontiguousarray(np.einsum("gkk->gk", self._reflections))

    def _reflection(self, axis: int) -> Array:
        """Of vectors about one of the planes, (3, 3)."""
        mirror = np.eye(3)
        mirror[axis, axis] = -1.0
        return np.asarray(self.rotation @ mirror @ self.rotation.T)


def _piece(shape: tuple[int, int], planes: tuple[int, ...]) -> tuple[int, int]:
    """Nodes of the patch on the non-negative sides of its planes, each of which has nodes on it."""
    along, across = ((n + 1) // 2 if axis in planes else n for axis, n in enumerate(shape))
    return along, across


@compiled
def _add_near(blocks: Array, piece: IntArray, flips: IntArray, near: Array, kind: IntArray, share: Array) -> None:
    """flips: (2^p, 2) whether an image of the piece is reversed along an axis.  near: (2^p, m, ...) with forces
    reflected as the image is.
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
    blocks: Array, side: IntArray, place: IntArray, signs: Array, moved: IntArray, loaded: IntArray, result: Array
) -> None:
    """Blocks of nodes whose images differ by signs (2^p, 3) of their vectors' components."""
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
            factors[j, c] = signs[other, c]
    for i in range(len(moved)):
        own, row = side[moved[i]], 3 * place[moved[i]]
        chosen = block[own]
        for a in range(3):
            sign, target = signs[own, a], result[3 * i + a]
            for j in range(count):
                source = blocks[chosen[j], row + a]
                target[3 * j] = sign * factors[j, 0] * source[column[j]]
                target[3 * j + 1] = sign * factors[j, 1] * source[column[j] + _ONE]
                target[3 * j + 2] = sign * factors[j, 2] * source[column[j] + _TWO]


@compiled
def _gather(
    blocks: Array, side: IntArray, place: IntArray, reflections: Array, moved: IntArray, loaded: IntArray, result: Array
) -> None:
    """Blocks of nodes whose images differ by any reflection (2^p, 3, 3) of their vectors."""
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
