"""Two bodies that face each other answer loads on single nodes as half-spaces do."""

from dataclasses import replace
from math import log

import numpy as np

from geometry import ContactPatch
from geometry.arrays import Array, IntArray
from solvers.patch_compliance import Bricks, missing_displacement
from solvers.placement import PlacedBody

_ALIKE = 2.0  #: Elements whose sizes differ by less than this factor are corrected alike, in proportion to their size.
_KINDS = 2  #: Elements larger than the finest by more than so many of these factors are corrected as those are.


def facing(primary: PlacedBody, secondary: PlacedBody) -> PlacedBody:
    """The body that carries the tractions, with what both bodies' elements lack near a loaded node.

    The near field belongs to the pair: a force on a node of the primary reaches the secondary spread over elements of
    both. Bodies without bricks under their patches are left as they are.
    """
    own, other = primary.bricks, secondary.bricks
    if own is None or other is None:
        return primary
    turn = secondary.world_to_patch @ primary.world_to_patch.T
    finest = (*_finest(primary.patch), *_finest(secondary.patch))
    sizes = _sizes(primary, secondary)[primary.folded.piece_nodes()]
    steps = np.clip(np.rint(np.log(sizes / finest) / log(_ALIKE) - 1e-6), 0, _KINDS)
    kinds, kind = np.unique(steps.astype(int), axis=0, return_inverse=True)
    near = _near_fields(kinds, finest, own, other, turn)
    # Alike lattices answer with displacements that go with one over their size.
    share = (finest * _ALIKE**steps / sizes)[:, :2].prod(axis=1) ** 0.5
    return replace(primary, folded=primary.folded.with_neighbours(near, kind.ravel(), share))


def _near_fields(kinds: IntArray, finest: tuple[float, ...], own: Bricks, other: Bricks, turn: Array) -> Array:
    """Displacements lacking about nodes of each kind (m, 4), (m, 2 a + 1, 2 t + 1, 3, 3)."""
    ways = ((float(turn[0, 0]), float(turn[0, 1])), (float(turn[1, 0]), float(turn[1, 1])))
    found = []
    for steps in kinds:
        a, t, b, u = (float(size * _ALIKE**step) for size, step in zip(finest, steps, strict=True))
        found.append(missing_displacement(own, (a, t), other, (b, u), ways))
    width = np.max([each.shape[:2] for each in found], axis=0)
    near = np.zeros((len(found), *width, 3, 3))
    for place, each in zip(near, found, strict=True):
        low = (width - each.shape[:2]) // 2
        place[low[0] : low[0] + each.shape[0], low[1] : low[1] + each.shape[1]] = each
    return near


def _finest(patch: ContactPatch) -> tuple[float, float]:
    """Size of the elements in the middle of a patch along and across."""
    along, across = (float(np.diff(lines)[len(lines) // 2]) for lines in (patch.axial_mm, patch.transverse_mm))
    return along, across


def _sizes(primary: PlacedBody, secondary: PlacedBody) -> Array:
    """Sizes (n, 4) along and across of the elements about the primary's nodes, and of those that face them at rest."""
    own, other = primary.patch, secondary.patch
    there = primary.node_positions @ secondary.world_to_patch.T
    along, across = np.meshgrid(_about(own.axial_mm), _about(own.transverse_mm), indexing="ij")
    facing_along = np.interp(there[:, 0], other.axial_mm, _about(other.axial_mm))
    facing_across = np.interp(there[:, 1], other.transverse_mm, _about(other.transverse_mm))
    return np.column_stack([along.ravel(), across.ravel(), facing_along, facing_across])


def _about(lines: Array) -> Array:
    """Mean size of the elements on both sides of each line."""
    return np.gradient(lines)
