"""Transfer between the nodes of a contact and those of a patch: weights at few nodes each."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import prod

import numpy as np
from scipy.sparse import csr_matrix

from geometry.arrays import Array, IntArray
from solvers.kept_code import compiled


@dataclass(frozen=True)
class NodalTransfer:
    """Weights of a patch's nodes at each of k contact nodes, row after row.

    first: (k + 1,) where each row's entries begin and the last ends.  columns, weights: (e,) patch nodes and weights.
    size: number n of the patch's nodes.
    """

    first: IntArray
    columns: IntArray
    weights: Array
    size: int

    @classmethod
    def single(cls, nodes: IntArray, weights: Array, size: int) -> NodalTransfer:
        """One patch node with a weight for each contact node, both (k,)."""
        return cls(np.arange(len(nodes) + 1), nodes, weights, size)

    def averaged(self, field: Array, rows: IntArray | None = None) -> Array:
        """Weighted sum of a nodal field (n,) or (n, c) at each contact node, or at some of them, (k,) or (k, c)."""
        chosen = np.arange(len(self.first) - 1) if rows is None else rows
        values = np.ascontiguousarray(field).reshape(self.size, prod(field.shape[1:]))
        result = weighted_sums(self.first, self.columns, self.weights, values, chosen)
        return result.reshape(len(chosen), *field.shape[1:])

    def spread(self, values: Array) -> Array:
        """What values (k,) or (k, c) at the contact nodes come to at the patch's, (n,) or (n, c): the transpose."""
        rows = np.ascontiguousarray(values).reshape(len(self.first) - 1, prod(values.shape[1:]))
        result = _spread(self.first, self.columns, self.weights, rows, self.size)
        return result.reshape(self.size, *values.shape[1:])

    def faced_by(self, rows: IntArray) -> IntArray:
        """The patch nodes (e,) of the entries of some contact nodes (m,), row after row."""
        return _entries(self.first, self.columns, rows)

    def among(self, nodes: IntArray, places: IntArray) -> NodalTransfer:
        """The same transfer from some of the patch's nodes (w,), which it must not leave; places: (n,) among them."""
        return NodalTransfer(self.first, places[self.columns], self.weights, len(nodes))

    def at_heaviest(self, chosen: IntArray) -> NodalTransfer:
        """This transfer with the whole weight of some rows (m,) at that of their nodes which weighs most."""
        nodes, sums = _heaviest(self.first, self.columns, self.weights, chosen)
        return self.with_rows(chosen, NodalTransfer.single(nodes, sums, self.size), np.arange(len(chosen)))

    def with_rows(self, chosen: IntArray, other: NodalTransfer, rows: IntArray) -> NodalTransfer:
        """This transfer with some rows (m,) replaced by rows (m,) of another onto the same patch."""
        first, columns, weights = _with_rows(
            self.first, self.columns, self.weights, chosen, other.first, other.columns, other.weights, rows
        )
        return NodalTransfer(first, columns, weights, self.size)

    @cached_property
    def sparse(self) -> csr_matrix:
        """The same as a (k, n) matrix."""
        return csr_matrix((self.weights, self.columns, self.first), shape=(len(self.first) - 1, self.size))


@compiled
def loaded_nodes(forces: Array) -> IntArray:
    """Nodes (l,), increasing, on which forces (n, 3) act."""
    found = np.empty(len(forces), dtype=np.int64)
    used = 0
    for node in range(len(forces)):
        if forces[node, 0] != 0.0 or forces[node, 1] != 0.0 or forces[node, 2] != 0.0:
            found[used] = node
            used += 1
    return found[:used]


@compiled
def _entries(first: IntArray, columns: IntArray, rows: IntArray) -> IntArray:
    size = 0
    for row in rows:
        size += first[row + 1] - first[row]
    found = np.empty(size, dtype=np.int64)
    used = 0
    for row in rows:
        for entry in range(first[row], first[row + 1]):
            found[used] = columns[entry]
            used += 1
    return found


@compiled
def weighted_sums(first: IntArray, columns: IntArray, weights: Array, field: Array, rows: IntArray) -> Array:
    """A transfer's sums (m, c) of a field (n, c) at its rows (m,)."""
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
def _heaviest(first: IntArray, columns: IntArray, weights: Array, chosen: IntArray) -> tuple[IntArray, Array]:
    nodes, sums = np.empty(len(chosen), dtype=np.int64), np.zeros(len(chosen))
    for m in range(len(chosen)):
        heaviest = first[chosen[m]]
        for entry in range(first[chosen[m]], first[chosen[m] + 1]):
            sums[m] += weights[entry]
            if weights[entry] > weights[heaviest]:
                heaviest = entry
        nodes[m] = columns[heaviest]
    return nodes, sums


@compiled
def _with_rows(
    first: IntArray,
    columns: IntArray,
    weights: Array,
    chosen: IntArray,
    other_first: IntArray,
    other_columns: IntArray,
    other_weights: Array,
    rows: IntArray,
) -> tuple[IntArray, IntArray, Array]:
    replacement = np.full(len(first) - 1, -1)
    for m in range(len(chosen)):
        replacement[chosen[m]] = rows[m]
    starts = np.zeros(len(first), dtype=np.int64)
    for row in range(len(first) - 1):
        other = replacement[row]
        count = first[row + 1] - first[row] if other < 0 else other_first[other + 1] - other_first[other]
        starts[row + 1] = starts[row] + count
    new_columns = np.empty(starts[-1], dtype=np.int64)
    new_weights = np.empty(starts[-1])
    for row in range(len(first) - 1):
        other = replacement[row]
        for entry in range(starts[row + 1] - starts[row]):
            if other < 0:
                new_columns[starts[row] + entry] = columns[first[row] + entry]
                new_weights[starts[row] + entry] = weights[first[row] + entry]
            else:
                new_columns[starts[row] + entry] = other_columns[other_first[other] + entry]
                new_weights[starts[row] + entry] = other_weights[other_first[other] + entry]
    return starts, new_columns, new_weights
