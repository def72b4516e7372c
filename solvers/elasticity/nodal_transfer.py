"""Sparse weights that transfer nodal fields from a patch's grid to contact nodes, and nodal forces back.

Where the axes of two grids lie along one another, integrals of products of their hat functions separate: a row of the
transfer is the outer product of a row along each axis. An axis' lines are its grid lines.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import prod
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_matrix

from geometry import ContactPatch
from geometry.arrays import Array, BoolArray, IntArray
from solvers.jit_cache import compiled, inlined

ROUND_OFF = 1e-9  #: How far beside a patch, in cells, a point still counts as on it.


class NodalTransfer(NamedTuple):
    """Weights of a patch's n nodes at each of k contact nodes: a sparse (k, n) matrix in compressed rows (CSR)."""

    first: IntArray  #: (k + 1,) index of each row's first entry, and the number of all entries.
    columns: IntArray  #: (e,) patch node of each entry.
    weights: Array  #: (e,) weight of each entry.
    size: int  #: Number n of the patch's nodes.

    @classmethod
    def single(cls, nodes: IntArray, weights: Array, size: int) -> NodalTransfer:
        """The transfer in which contact node i takes the patch node nodes[i] alone, times weights[i], (k,) each; size:
        number of the patch's nodes.
        """
        return cls(np.arange(len(nodes) + 1), nodes, weights, size)

    @classmethod
    def of(cls, matrix: csr_matrix) -> NodalTransfer:
        """The transfer with the entries of a sparse (k, n) matrix; inverse of `sparse`."""
        return cls(matrix.indptr, matrix.indices, matrix.data, int(matrix.shape[1]))

    def averaged(self, field: Array, rows: IntArray | None = None) -> Array:
        """Weighted sums, (k,) or (k, c), of a nodal field (n,) or (n, c) of the patch at the contact nodes; rows:
        indices of those that are wanted alone, None: all.
        """
        chosen = np.arange(len(self.first) - 1) if rows is None else rows
        values = np.ascontiguousarray(field).reshape(self.size, prod(field.shape[1:]))
        result = weighted_sums(self.first, self.columns, self.weights, values, chosen)
        return result.reshape(len(chosen), *field.shape[1:])

    def spread(self, values: Array) -> Array:
        """Sums, (n,) or (n, c), at the patch's nodes of weighted values (k,) or (k, c) at the contact nodes: the matrix
        transposed.
        """
        rows = np.ascontiguousarray(values).reshape(len(self.first) - 1, prod(values.shape[1:]))
        result = _spread(self.first, self.columns, self.weights, rows, self.size)
        return result.reshape(self.size, *values.shape[1:])

    def among(self, rows: IntArray) -> NodalTransfer:
        """The contact nodes of index `rows` (m,) alone."""
        first = np.concatenate([[0], np.cumsum(np.diff(self.first)[rows])])
        entries = _entries(self.first, rows)
        return NodalTransfer(first, self.columns[entries], self.weights[entries], self.size)

    def faced_by(self, rows: IntArray) -> IntArray:
        """The patch nodes (e,) of all entries of contact nodes of index `rows` (m,), row after row, with repeats."""
        return np.asarray(self.columns[_entries(self.first, rows)])

    def at_heaviest(self, chosen: IntArray) -> NodalTransfer:
        """This transfer with, in the rows of index `chosen` (m,), all weight on the patch node that has the largest."""
        return NodalTransfer(*_at_heaviest(self.first, self.columns, self.weights, chosen), self.size)

    @property
    def sparse(self) -> csr_matrix:
        return csr_matrix((self.weights, self.columns, self.first), shape=(len(self.first) - 1, self.size))


@compiled
def loaded_nodes(forces: Array) -> IntArray:
    """Indices (l,), increasing, of the nodes with a non-zero force among (n, 3)."""
    found = np.empty(len(forces), dtype=np.int64)
    used = 0
    for node in range(len(forces)):
        if forces[node, 0] != 0.0 or forces[node, 1] != 0.0 or forces[node, 2] != 0.0:
            found[used] = node
            used += 1
    return found[:used]


@compiled
def _entries(first: IntArray, rows: IntArray) -> IntArray:
    """Indices (e,) of the entries of some rows, row after row."""
    size = 0
    for row in rows:
        size += first[row + 1] - first[row]
    found = np.empty(size, dtype=np.int64)
    used = 0
    for row in rows:
        for entry in range(first[row], first[row + 1]):
            found[used] = entry
            used += 1
    return found


@compiled
def weighted_sums(first: IntArray, columns: IntArray, weights: Array, field: Array, rows: IntArray) -> Array:
    """Weighted sums (m, c) of a field (n, c) at `rows` (m,) of the transfer of these first, columns and weights, see
    `NodalTransfer`.
    """
    result = np.zeros((len(rows), field.shape[1]))
    for k in range(len(rows)):
        for entry in range(first[rows[k]], first[rows[k] + 1]):
            for c in range(field.shape[1]):
                result[k, c] += weights[entry] * field[columns[entry], c]
    return result


@compiled
def _spread(first: IntArray, columns: IntArray, weights: Array, values: Array, size: int) -> Array:
    result = np.zeros((size, values.shape[1]))
    for row in range(len(first) - 1):
        for entry in range(first[row], first[row + 1]):
            for c in range(values.shape[1]):
                result[columns[entry], c] += weights[entry] * values[row, c]
    return result


@compiled
def _at_heaviest(
    first: IntArray, columns: IntArray, weights: Array, chosen: IntArray
) -> tuple[IntArray, IntArray, Array]:
    whole = np.zeros(len(first) - 1, np.bool_)
    for row in chosen:
        whole[row] = True
    starts, used = np.zeros_like(first), 0
    new_columns, new_weights = np.empty_like(columns), np.empty_like(weights)
    for row in range(len(whole)):
        heaviest = first[row]
        for entry in range(first[row], first[row + 1]):
            if not whole[row] or entry == first[row]:
                new_columns[used], new_weights[used] = columns[entry], weights[entry]
                used += 1
                continue
            new_weights[used - 1] += weights[entry]
            if weights[entry] > weights[heaviest]:
                heaviest = entry
                new_columns[used - 1] = columns[entry]
        starts[row + 1] = used
    return starts, new_columns[:used].copy(), new_weights[:used].copy()


@dataclass(frozen=True)
class GaussLines:
    """Gauss points along one axis of a patch, q in each of c cells; across a planar body a single one, 1 mm long."""

    positions: Array  #: (c, q) mm.
    lengths: Array  #: (c, q) length of the axis that each point stands for, mm.
    lower: Array  #: (q,) value of the hat function of the cell's lower grid line at the points.

    @property
    def planar(self) -> bool:
        return self.positions.shape == (1, 1)


def gauss_lines(lines: Array, points: int) -> GaussLines:
    """Gauss points of one axis, `points` in each cell between lines (c + 1,) in mm; a single line: a planar body's."""
    if len(lines) == 1:
        return GaussLines(lines[:, None], np.ones((1, 1)), np.ones(1))
    abscissae, weights = np.polynomial.legendre.leggauss(points)
    size = np.diff(lines)[:, None]
    share = 0.5 * (abscissae + 1.0)
    return GaussLines(lines[:-1, None] + share * size, 0.5 * weights * size, 1.0 - share)


class CommonAxes(NamedTuple):
    """Transformation of positions into another patch's axes at a multiple of 90°: signs * (position - offset),
    components swapped if `swapped`.
    """

    swapped: bool  #: True if the first axis lies along the other patch's second.
    signs: Array  #: (2,) 1 or -1, by the axes from which is transformed.
    offset: Array  #: (2,) the other patch's origin in these axes.

    @classmethod
    def of(cls, turn: Array, offset: Array) -> CommonAxes | None:
        """The transformation turn @ (position - offset) with `turn` (2, 2) and `offset` (2,); None unless it turns by a
        multiple of 90°.
        """
        if turn[0, 1] == 0.0 == turn[1, 0]:
            return cls(False, np.array([turn[0, 0], turn[1, 1]]), offset)
        if turn[0, 0] == 0.0 == turn[1, 1]:
            return cls(True, np.array([turn[1, 0], turn[0, 1]]), offset)
        return None


def transfer_along_axes(
    nodes: IntArray, along: GaussLines, across: GaussLines, axes: CommonAxes, patch: ContactPatch
) -> tuple[BoolArray, IntArray, IntArray, Array]:
    """Integrals of products of hat functions between nodes (k,) of one patch and all nodes of the other body's `patch`.

    along, across: Gauss points of the first patch.  axes: from its axes to those of `patch`. Returns whether each
    node's support leaves `patch`, (k,), and first, columns and weights as in `NodalTransfer`.
    """
    lines = (patch.transverse_mm, patch.axial_mm) if axes.swapped else (patch.axial_mm, patch.transverse_mm)
    strides = (1, len(patch.transverse_mm)) if axes.swapped else (len(patch.transverse_mm), 1)
    count_t = 1 if across.planar else len(across.positions) + 1
    own = [
        (each.positions, each.lengths, each.lower, axes.signs[c], axes.offset[c], lines[c], each.planar)
        for c, each in enumerate((along, across))
    ]
    return _products(nodes, count_t, own[0], own[1], strides)


@inlined
def cell_of(lines: Array, value: float, near: int) -> int:
    """Index of the cell between increasing grid lines that holds a value, or of the nearest cell; the search starts at
    cell `near`.
    """
    while near > 0 and lines[near] > value:
        near -= 1
    while near < len(lines) - 2 and lines[near + 1] <= value:
        near += 1
    return near


#: Arguments of `_along_line`.
_Line = tuple[Array, Array, Array, float, float, Array, bool]


@compiled
def _along_line(
    positions: Array, lengths: Array, lower: Array, sign: float, offset: float, other: Array, planar: bool
) -> tuple[BoolArray, IntArray, IntArray, Array]:
    """For every grid line of an axis: True if its support leaves the other grid, and its integrals with the other's hat
    functions.

    other: (m,) the other grid's lines.  The integrals are sparse rows: first (lines + 1,), columns, values.
    """
    cells = positions.shape[0]
    count = 1 if planar else cells + 1
    outside, first = np.zeros(count, dtype=np.bool_), np.zeros(count + 1, dtype=np.int64)
    columns, values = np.empty(count * len(other), dtype=np.int64), np.empty(count * len(other))
    row = np.zeros(len(other))
    used = at = 0
    for i in range(count):
        low, high = len(other), -1
        for cell in range(max(i - 1, 0), min(i + 1, cells)):
            for p in range(len(lower)):
                weight = lengths[cell, p] * (lower[p] if cell == i else 1.0 - lower[p])
                share = 0.0
                if len(other) > 1:
                    place = sign * (positions[cell, p] - offset)
                    at = cell_of(other, place, at)
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
    nodes: IntArray, count_t: int, along: _Line, across: _Line, strides: tuple[int, int]
) -> tuple[BoolArray, IntArray, IntArray, Array]:
    """Integrals of each node's hat function with those of the other grid: products of the integrals along both axes.

    nodes: (k,) numbers of nodes of a grid with `count_t` lines across. along, across: arguments of `_along_line`.
    strides: what a step of one line, along and across, adds to a node's number in the other grid. Returns (k,) True
    where a node's support leaves the other grid, and sparse rows: first (k + 1,), columns, values.
    """
    outside_a, first_a, columns_a, values_a = _along_line(*along)
    outside_t, first_t, columns_t, values_t = _along_line(*across)
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
                columns[used] = columns_a[a] * strides[0] + columns_t[t] * strides[1]
                weights[used] = values_a[a] * values_t[t]
                used += 1
    return outside, first, columns, weights
