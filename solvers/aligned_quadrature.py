"""Transfer between two grids whose axes lie along one another, as between wires crossed at right angles.

A product of hat functions is then integrated along one axis and along the other apart: a row of the transfer is the
outer product of a row along each.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from geometry import ContactPatch
from geometry.arrays import Array, BoolArray, IntArray
from solvers.kept_code import compiled

ROUND_OFF = 1e-9  #: How far beside a patch, in cells, a point still counts as on it.


@dataclass(frozen=True)
class GaussLines:
    """Gauss points along one axis of a patch, q in each of its c cells; of a planar body's width one of length 1.

    positions, lengths: (c, q), mm.  lower: (q,) hat function of the cell's lower line at its points.
    """

    positions: Array
    lengths: Array
    lower: Array

    @property
    def planar(self) -> bool:
        """Whether this is a planar body's width."""
        return self.positions.shape == (1, 1)


def gauss_lines(lines: Array, points: int) -> GaussLines:
    """Gauss points between grid lines (c + 1,)."""
    if len(lines) == 1:
        return GaussLines(lines[:, None], np.ones((1, 1)), np.ones(1))
    abscissae, weights = np.polynomial.legendre.leggauss(points)
    size = np.diff(lines)[:, None]
    share = 0.5 * (abscissae + 1.0)
    return GaussLines(lines[:-1, None] + share * size, 0.5 * weights * size, 1.0 - share)


class CommonAxes(NamedTuple):
    """How positions (x, y) in a patch's axes are seen in those of another: (signs * ((x, y) - offset)), or swapped.

    swapped: whether the patch's first axis lies along the other's second.  signs, offset: (2,) for the patch's axes.
    """

    swapped: bool
    signs: Array
    offset: Array

    @classmethod
    def of(cls, turn: Array, offset: Array) -> "CommonAxes | None":
        """Those of positions at `turn @ (position - offset)`; None where the axes lie at another angle."""
        if turn[0, 1] == 0.0 == turn[1, 0]:
            return cls(False, np.array([turn[0, 0], turn[1, 1]]), offset)
        if turn[0, 0] == 0.0 == turn[1, 1]:
            return cls(True, np.array([turn[1, 0], turn[0, 1]]), offset)
        return None


def transfer_along_axes(
    nodes: IntArray, along: GaussLines, across: GaussLines, axes: CommonAxes, patch: ContactPatch
) -> tuple[BoolArray, IntArray, IntArray, Array]:
    """Which supports of nodes (k,) leave the other body's `patch`, and the transfer from there as `NodalTransfer` keeps
    it: first, columns, weights.
    """
    lines = (patch.transverse_mm, patch.axial_mm) if axes.swapped else (patch.axial_mm, patch.transverse_mm)
    strides = (1, len(patch.transverse_mm)) if axes.swapped else (len(patch.transverse_mm), 1)
    count_t = 1 if across.planar else len(across.positions) + 1
    of_axes = (
        (own.positions, own.lengths, own.lower, axes.signs[c], axes.offset[c], lines[c], own.planar, strides[c])
        for c, own in enumerate((along, across))
    )
    return _products(nodes, count_t, *next(of_axes), *next(of_axes))


@compiled
def cell_of(lines: Array, value: float) -> int:
    """The cell between lines that holds a value, the first or the last for one beside them."""
    low, high = 0, len(lines) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if lines[middle] <= value:
            low = middle
        else:
            high = middle
    return low


@compiled
def _along_line(
    positions: Array, lengths: Array, lower: Array, sign: float, offset: float, other: Array, planar: bool
) -> tuple[BoolArray, IntArray, IntArray, Array]:
    """Of every line of an axis: whether its support leaves the other grid, and integrals of products of hat functions.

    other: (m,) the other grid's lines.  The rows: first (lines + 1,), columns, values.
    """
    cells = positions.shape[0]
    count = 1 if planar else cells + 1
    outside, first = np.zeros(count, dtype=np.bool_), np.zeros(count + 1, dtype=np.int64)
    columns, values = np.empty(count * len(other), dtype=np.int64), np.empty(count * len(other))
    row = np.zeros(len(other))
    used = 0
    for i in range(count):
        low, high = len(other), -1
        for cell in range(max(i - 1, 0), min(i + 1, cells)):
            for p in range(len(lower)):
                weight = lengths[cell, p] * (lower[p] if cell == i else 1.0 - lower[p])
                at = 0
                share = 0.0
                if len(other) > 1:
                    place = sign * (positions[cell, p] - offset)
                    at = cell_of(other, place)
                    share = (place - other[at]) / (other[at + 1] - other[at])
                    if share < -ROUND_OFF or share > 1.0 + ROUND_OFF:
                        outside[i] |= weight > 0.0
                        continue
                    row[at + 1] += weight * share
                row[at] += weight * (1.0 - share)
                low, high = min(low, at), max(high, min(at + 1, len(other) - 1))
        for c in range(low, high + 1):
            columns[used], values[used] = c, row[c]
            row[c] = 0.0
            used += 1
        first[i + 1] = used
    return outside, first, columns, values


@compiled
def _products(
    nodes: IntArray,
    count_t: int,
    positions_a: Array,
    lengths_a: Array,
    lower_a: Array,
    sign_a: float,
    offset_a: float,
    other_a: Array,
    planar_a: bool,
    stride_a: int,
    positions_t: Array,
    lengths_t: Array,
    lower_t: Array,
    sign_t: float,
    offset_t: float,
    other_t: Array,
    planar_t: bool,
    stride_t: int,
) -> tuple[BoolArray, IntArray, IntArray, Array]:
    """The outer products of rows along both axes, of each `_along_line`'s arguments and the other grid's stride."""
    outside_a, first_a, columns_a, values_a = _along_line(
        positions_a, lengths_a, lower_a, sign_a, offset_a, other_a, planar_a
    )
    outside_t, first_t, columns_t, values_t = _along_line(
        positions_t, lengths_t, lower_t, sign_t, offset_t, other_t, planar_t
    )
    count = len(nodes)
    outside, first = np.empty(count, dtype=np.bool_), np.zeros(count + 1, dtype=np.int64)
    for k in range(count):
        i, j = nodes[k] // count_t, nodes[k] % count_t
        outside[k] = outside_a[i] or outside_t[j]
        first[k + 1] = first[k] + (first_a[i + 1] - first_a[i]) * (first_t[j + 1] - first_t[j])
    columns, weights = np.empty(first[-1], dtype=np.int64), np.empty(first[-1])
    used = 0
    for k in range(count):
        i, j = nodes[k] // count_t, nodes[k] % count_t
        for a in range(first_a[i], first_a[i + 1]):
            for t in range(first_t[j], first_t[j + 1]):
                columns[used] = columns_a[a] * stride_a + columns_t[t] * stride_t
                weights[used] = values_a[a] * values_t[t]
                used += 1
    return outside, first, columns, weights
