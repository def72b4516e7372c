"""Gaps and slips of nodes in the equations of one Newton iteration: what unknown tractions and the holder do to them.

Unknowns stand in this order: normal tractions of the nodes `on` (a,), those along the first and along the second
tangent of the nodes `tan` (m,), then the holder's height, position and tilt. Rows stand in the same order: no gap, no
slip or the friction law, the holder's equilibrium. Matrices are filled transposed, as LAPACK wants them.
"""

from typing import NamedTuple

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.kept_code import inlined
from solvers.newton.terms import Carried, LayerTerms, Nodes


class Loaded(NamedTuple):
    """What tractions on nodes do, see `Responses`: columns of `matrix` at a node's `place`; the layer's compliance.

    known: nodes that have columns.  follow: (f,) nodes whose friction follows a known direction.
    """

    matrix: Array
    known: int
    place: IntArray
    layer: float
    follow: IntArray


@inlined
def gap_rows(
    loaded: Loaded, nodes: Nodes, carried: Carried, layers: LayerTerms, on: IntArray, tan: IntArray
) -> tuple[Array, Array]:
    """The transposed matrix (size, size) and right-hand side (size,) of all unknowns, with rows of no gap filled."""
    size = len(on) + 2 * len(tan) + 3
    transposed, rhs = np.zeros((size, size)), np.zeros(size)
    moved, row = np.empty(3 * loaded.known), np.empty(size - 3)
    for i in range(len(on)):
        node = on[i]
        upward, rate = nodes.frames[node, 0, 2], nodes.gap_rate[node]
        _moved_along(loaded.matrix, nodes.frames, node, 0, moved)
        _fill_row(row, moved, loaded.place, nodes.frames, carried.per_normal, on, tan)
        _add_layer(row, loaded.layer, nodes.frames, carried.per_normal, node, 0, on, tan)
        for j in range(size - 3):
            transposed[j, i] = row[j]
        transposed[size - 3, i] = upward
        transposed[size - 2, i] = upward * rate
        transposed[size - 1, i] = upward * nodes.lever[node]
        transposed[i, i] += layers.softness[node]
        rhs[i] = -upward * (nodes.gap[node] - rate * nodes.paired_holder_x) - layers.closure[node]
        if carried.shifted:
            rhs[i] -= _by_constant(loaded, nodes.frames, carried.constant, moved, node, 0)
    return transposed, rhs


@inlined
def slip_rows(
    loaded: Loaded, nodes: Nodes, carried: Carried, layers: LayerTerms, tangential: Array, on: IntArray, tan: IntArray
) -> tuple[Array, Array]:
    """Slip of the m nodes with tangential unknowns along both tangents: rows (2 m, size), constant part (2 m,).

    tangential: (k, 2) about which layers are linearised.
    """
    a, m = len(on), len(tan)
    size = a + 2 * m + 3
    rows, offset = np.zeros((2 * m, size)), np.empty(2 * m)
    moved = np.empty(3 * loaded.known)
    place = np.full(len(nodes.areas), -1)
    for i in range(a):
        place[on[i]] = i
    for number in range(2 * m):
        axis, node, row = 1 + number // m, tan[number % m], rows[number]
        tangent, old, lever = nodes.frames[node, axis], nodes.old_displacement[node], nodes.lever[node]
        _moved_along(loaded.matrix, nodes.frames, node, axis, moved)
        _fill_row(row, moved, loaded.place, nodes.frames, carried.per_normal, on, tan)
        _add_layer(row, loaded.layer, nodes.frames, carried.per_normal, node, axis, on, tan)
        row[size - 3], row[size - 2], row[size - 1] = tangent[2], tangent[0], tangent[2] * lever
        constant = tangent[0] * (-nodes.old_holder_x - nodes.drive_step - old[0]) - tangent[1] * old[1]
        constant += tangent[2] * (-nodes.old_height - lever * nodes.old_tilt - old[2])
        if carried.shifted:
            constant += _by_constant(loaded, nodes.frames, carried.constant, moved, node, axis)
        change = layers.change[node] * tangential[node, axis - 1]
        row[a + number] += layers.shear[node]
        row[place[node]] += change
        constant -= change * layers.pressure[node]
        for c in range(3):
            constant -= tangent[c] * nodes.old_sheared[node, c]
        offset[number] = constant
    return rows, offset


@inlined
def _moved_along(matrix: Array, frames: Array, node: int, axis: int, moved: Array) -> None:
    """Write the displacement of a node along an axis of its frame by unit tractions on all nodes of the responses."""
    x, y, z = frames[node, axis, 0], frames[node, axis, 1], frames[node, axis, 2]
    row = 3 * node
    for c in range(len(moved)):
        moved[c] = x * matrix[row, c] + y * matrix[row + 1, c] + z * matrix[row + 2, c]


@inlined
def _fill_row(
    row: Array, moved: Array, place: IntArray, frames: Array, per_normal: Array, on: IntArray, tan: IntArray
) -> None:
    """Write that displacement by each unknown traction."""
    a, m = len(on), len(tan)
    for j in range(a):
        node = on[j]
        p = 3 * place[node]
        row[j] = (
            per_normal[node, 0] * moved[p] + per_normal[node, 1] * moved[p + 1] + per_normal[node, 2] * moved[p + 2]
        )
    for j in range(m):
        node = tan[j]
        p = 3 * place[node]
        x, y, z = moved[p], moved[p + 1], moved[p + 2]
        row[a + j] = frames[node, 1, 0] * x + frames[node, 1, 1] * y + frames[node, 1, 2] * z
        row[a + m + j] = frames[node, 2, 0] * x + frames[node, 2, 1] * y + frames[node, 2, 2] * z


@inlined
def _add_layer(
    row: Array, layer: float, frames: Array, per_normal: Array, node: int, axis: int, on: IntArray, tan: IntArray
) -> None:
    """Add what an elastic layer between the bodies gives way along an axis by the node's own tractions."""
    if layer == 0.0:
        return
    a, m = len(on), len(tan)
    for c in range(3):
        along = layer * frames[node, axis, c]
        for j in range(a):
            if on[j] == node:
                row[j] += along * per_normal[node, c]
        for j in range(m):
            if tan[j] == node:
                row[a + j] += along * frames[node, 1, c]
                row[a + m + j] += along * frames[node, 2, c]


@inlined
def _by_constant(loaded: Loaded, frames: Array, constant: Array, moved: Array, node: int, axis: int) -> float:
    """Displacement of a node by the constant tractions (k, 3) of those whose friction follows a known direction."""
    total = 0.0
    for other in loaded.follow:
        p = 3 * loaded.place[other]
        for c in range(3):
            total += constant[other, c] * moved[p + c]
            if other == node:
                total += loaded.layer * frames[node, axis, c] * constant[other, c]
    return total
