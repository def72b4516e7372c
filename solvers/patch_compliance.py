"""The compliance of a body at its contact patch, stored by its mirror symmetries.

A body that is its own mirror image about a plane answers forces that are even about it with even displacements, odd
ones with odd ones. Each kind belongs to the piece on one side alone, held on the plane accordingly: its displacement
across the plane is zero there if it is even, that along the plane if it is odd. So a body with two such planes is four
times a quarter, a quarter of the numbers (Glockner, J. Struct. Div. ASCE 99 (1973) 71).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from solvers.errors import SolverError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PatchCompliance:
    """Displacements of a patch's nodes by forces on them, in mm/N; unknown 3 i + k belongs to node i and axis k.

    shape: (n_a, n_t) nodes of the patch.
    planes: the patch's axes, 0 along the body and 1 across it, about whose zero the body is its own mirror image.
    parts: (2^p, 3 q, 3 q) for p planes, the compliances of the piece on the planes' non-negative sides: even about each
    plane before odd, the last plane first to change. Its q nodes are those of the patch on that side, in the patch's
    order; those on a plane carry the piece's half of the forces there. What is held on a plane has compliance zero.
    rotation: (3, 3) from the body's axes, in which its planes are given, to those of the displacements.
    """

    shape: tuple[int, int]
    planes: tuple[int, ...]
    parts: Array
    rotation: Array = field(default_factory=lambda: np.eye(3))
    _halves: dict[tuple[int, bool], PatchCompliance] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        q = 3 * int(np.prod(_piece(self.shape, self.planes)))
        if self.parts.shape != (2 ** len(self.planes), q, q):
            raise SolverError(
                f"a patch of {self.shape} nodes with mirror planes {self.planes} has no compliance of shape "
                f"{self.parts.shape}"
            )

    def turned(self, rotation: Array) -> PatchCompliance:
        """The same displacements in other axes, by a matrix (3, 3) that turns vectors into them."""
        if np.array_equal(rotation, np.eye(3)):
            return self
        triples = np.ascontiguousarray(self.parts).reshape(-1, 3) @ rotation.T
        rows = triples.reshape(-1, 3, self.parts.shape[-1])
        return replace(self, parts=(rotation @ rows).reshape(self.parts.shape), rotation=rotation @ self.rotation)

    @cached_property
    def dense(self) -> Array:
        """The whole matrix (3 n, 3 n), put together when it is first asked for."""
        shape, parts = _piece(self.shape, self.planes), [np.asarray(part) for part in self.parts]
        for axis in self.planes[::-1]:
            reflection = self._reflection(axis)
            parts = [_unfolded(*pair, shape, axis, reflection) for pair in zip(parts[::2], parts[1::2], strict=True)]
            shape = (self.shape[0], shape[1]) if axis == 0 else (shape[0], self.shape[1])
        return parts[0]

    def diagonal(self) -> Array:
        """Displacement of each unknown by a unit force on itself, (3 n,)."""
        shape = _piece(self.shape, self.planes)
        q = int(np.prod(shape))
        node = np.arange(q)
        own = self.parts.reshape(-1, q, 3, q, 3)[:, node, :, node, :].mean(axis=1).reshape(*shape, 3, 3)
        for axis in self.planes:
            reflection = self._reflection(axis)
            images = reflection @ np.flip(own, axis).take(range(own.shape[axis] - 1), axis=axis) @ reflection
            own = np.concatenate([images, own], axis=axis)
        return np.asarray(np.einsum("...kk->...k", own).ravel())

    def half(self, plane: int, *, negative_side: bool = False) -> PatchCompliance:
        """That of one half of the body for what is even about a plane, kept once it has been asked for.

        The half is that on the plane's non-negative side with its nodes in the patch's order, or the other one with the
        images of these nodes in the same order. Nodes on the plane carry half of their force. SolverError when the body
        is no mirror image of itself there.
        """
        if plane not in self.planes:
            raise SolverError(f"the body is not its own mirror image about zero of its axis {plane}")
        if (plane, negative_side) not in self._halves:
            self._halves[plane, negative_side] = self._half(plane, negative_side=negative_side)
        return self._halves[plane, negative_side]

    def _half(self, plane: int, *, negative_side: bool) -> PatchCompliance:
        others = tuple(axis for axis in self.planes if axis != plane)
        by_plane = self.parts.reshape(*(2,) * len(self.planes), *self.parts.shape[1:])
        even = by_plane.take(0, axis=self.planes.index(plane)).reshape(-1, *self.parts.shape[1:])
        half = PatchCompliance(_piece(self.shape, (plane,)), others, even, self.rotation)
        return half.turned(self._reflection(plane)) if negative_side else half

    def _reflection(self, axis: int) -> Array:
        """Of vectors about one of the planes, (3, 3)."""
        mirror = np.eye(3)
        mirror[axis, axis] = -1.0
        return np.asarray(self.rotation @ mirror @ self.rotation.T)


def _piece(shape: tuple[int, int], planes: tuple[int, ...]) -> tuple[int, int]:
    """Nodes of the patch on the non-negative sides of its planes, each of which has nodes on it."""
    along, across = ((n + 1) // 2 if axis in planes else n for axis, n in enumerate(shape))
    return along, across


def _unfolded(even: Array, odd: Array, shape: tuple[int, int], axis: int, reflection: Array) -> Array:
    """The compliance of both sides of a plane from the even and odd one of its non-negative side.

    A force on one side is half its even and half its odd part.
    """
    halves = (*shape, 3, *shape, 3)
    count = 2 * shape[axis] - 1
    whole_shape = (count, shape[1]) if axis == 0 else (shape[0], count)
    whole = np.empty((*whole_shape, 3, *whole_shape, 3))
    same, across = 0.5 * (even + odd).reshape(halves), 0.5 * (even - odd).reshape(halves)

    def images(block: Array, side: int) -> Array:
        """The block at the images of its nodes off the plane, for its rows (side 0) or columns (side 3)."""
        off = block[(slice(None),) * (axis + side) + (slice(1, None),)]
        return np.flip(_reflected(off, reflection, side), axis + side)

    middle = shape[axis] - 1
    low, high = (
        tuple(part if k == axis else slice(None) for k in range(3)) for part in (slice(middle), slice(middle, None))
    )
    whole[(*high, *high)] = same
    whole[(*low, *high)] = images(across, 0)
    whole[(*high, *low)] = images(across, 3)
    whole[(*low, *low)] = images(images(same, 0), 3)
    size = 3 * int(np.prod(whole_shape))
    return whole.reshape(size, size)


def _reflected(block: Array, reflection: Array, side: int) -> Array:
    """A block (a, t, 3, a, t, 3) with the vectors of its rows (side 0) or columns (side 3) reflected."""
    signs = reflection.diagonal()
    if np.array_equal(reflection, np.diag(signs)):
        return np.asarray(block * (signs[:, None, None, None] if side == 0 else signs))
    if side == 3:
        return np.asarray(block @ reflection)
    rows = np.ascontiguousarray(block).reshape(block.shape[0] * block.shape[1], 3, -1)
    return np.asarray((reflection @ rows).reshape(block.shape))
