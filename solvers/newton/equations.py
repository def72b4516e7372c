"""The linear equations of one Newton iteration, and their solution.

Unknowns, and rows of the matrix: first the normal tractions of the nodes `on` (a,), with rows of zero gap; then the
tractions along the first and along the second tangent of the nodes `tan` (m,), with rows of zero slip or of the
friction law; then the holder's height, position and tilt, with rows of its equilibrium. The size is a + 2 m + 3. Nodes
that slip far follow a known direction: their friction is the linearised law's, an affine function of their normal
traction. Matrices are filled transposed, as LAPACK expects them.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack

from geometry.arrays import Array, BoolArray, IntArray
from solvers.jit_cache import compiled, inlined
from solvers.newton.conditions import (
    ContactConditions,
    Scales,
    Solution,
    fill_holder_rows,
    forces_on,
    held_place,
    stop_in_play,
)
from solvers.newton.terms import Carried, HolderTerms, Iterate, LinearLaws, Nodes, carried_by, holder_terms

#: Double precision solves no more equations than this as fast; what is left of the largest right-hand side; most steps.
_FEW, _LEFT, _IMPROVED = 400, 1e-13, 6


class Loaded(NamedTuple):
    """Displacements of the k nodes by unit tractions on those that are known, see `PairedCompliance`."""

    matrix: Array  #: (3 k, 3 known or more) mm per MPa.
    known: int
    place: IntArray  #: (k,) number of each node among the known ones, -1 if not known.
    layer: float  #: Compliance of an elastic layer between the bodies, mm per MPa.


@inlined
def gap_rows(
    loaded: Loaded, follow: IntArray, nodes: Nodes, carried: Carried, laws: LinearLaws, on: IntArray, tan: IntArray
) -> tuple[Array, Array]:
    """The transposed matrix (size, size) and the right-hand side (size,), in which only the rows of zero gap are
    filled, the first a.

    follow: indices of nodes whose friction follows a known direction. on, tan: indices of the nodes of the unknowns.
    """
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
        transposed[i, i] += laws.softness[node]
        rhs[i] = -upward * (nodes.gap[node] - rate * nodes.paired_holder_x) - laws.closure[node]
        if carried.shifted:
            rhs[i] -= _by_constant(loaded, follow, nodes.frames, carried.constant, moved, node, 0)
    return transposed, rhs


@inlined
def slip_rows(
    loaded: Loaded,
    follow: IntArray,
    nodes: Nodes,
    carried: Carried,
    laws: LinearLaws,
    tangential: Array,
    on: IntArray,
    tan: IntArray,
) -> tuple[Array, Array]:
    """Slips in mm of the m nodes `tan`, all along the first tangent, then along the second, as affine functions of the
    unknowns: (2 m, size) factors and (2 m,) constants.

    tangential: (k, 2) tangential tractions in MPa at which layers are linearised.
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
            constant += _by_constant(loaded, follow, nodes.frames, carried.constant, moved, node, axis)
        change = laws.change[node] * tangential[node, axis - 1]
        row[a + number] += laws.shear[node]
        row[place[node]] += change
        constant -= change * laws.pressure[node]
        for c in range(3):
            constant -= tangent[c] * nodes.old_sheared[node, c]
        offset[number] = constant
    return rows, offset


@inlined
def _moved_along(matrix: Array, frames: Array, node: int, axis: int, moved: Array) -> None:
    """Write the displacement of a node along an axis of its frame by unit tractions on all known nodes to `moved`."""
    x, y, z = frames[node, axis, 0], frames[node, axis, 1], frames[node, axis, 2]
    row = 3 * node
    for c in range(len(moved)):
        moved[c] = x * matrix[row, c] + y * matrix[row + 1, c] + z * matrix[row + 2, c]


@inlined
def _fill_row(
    row: Array, moved: Array, place: IntArray, frames: Array, per_normal: Array, on: IntArray, tan: IntArray
) -> None:
    """Write the displacement `moved` by unit tractions as a function of the unknown tractions to `row`."""
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
    """Add the deformation of an elastic layer along an axis by the node's own tractions to `row`."""
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
def _by_constant(
    loaded: Loaded, follow: IntArray, frames: Array, constant: Array, moved: Array, node: int, axis: int
) -> float:
    """Displacement of a node by the constant part of the tractions (k, 3) of nodes whose friction follows a known
    direction.
    """
    total = 0.0
    for other in follow:
        p = 3 * loaded.place[other]
        for c in range(3):
            total += constant[other, c] * moved[p + c]
            if other == node:
                total += loaded.layer * frames[node, axis, c] * constant[other, c]
    return total


@inlined
def fill_friction_rows(
    transposed: Array,
    rhs: Array,
    slips: Array,
    offsets: Array,
    state: Iterate,
    laws: LinearLaws,
    on: IntArray,
    tan: IntArray,
) -> None:
    """Write the rows of the nodes `tan` into the transposed matrix and the right-hand side in place: zero slip, or the
    linearised projection onto the friction cone.

    slips, offsets: as from `slip_rows`. With the unknowns q the projection reads q - tau(p) d - weight (1 - d d^T)(q -
    augmentation s) = 0; the rows are multiplied by the slip per traction.
    """
    a, m = len(on), len(tan)
    column = np.full(len(state.limit), -1)
    for i in range(a):
        column[on[i]] = i
    for i in range(m):
        node = tan[i]
        augmentation, direction = state.augmentation[node], state.direction[node]
        trial_0 = state.tangential[node, 0] - augmentation * state.slip[node, 0]
        trial_1 = state.tangential[node, 1] - augmentation * state.slip[node, 1]
        size = max(np.sqrt(trial_0**2 + trial_1**2), 1e-300)
        weight = min(state.limit[node] / size, 1.0)
        for c in range(2):
            row = a + c * m + i
            if state.stick[node]:
                for j in range(len(transposed)):
                    transposed[j, row] = slips[c * m + i, j]
                rhs[row] = -offsets[c * m + i]
                continue
            transposed[row, row] = 1.0 / augmentation
            transposed[column[node], row] = -laws.slope[node] * direction[c] / augmentation
            rhs[row] = laws.offset[node] * direction[c] / augmentation
            for e in range(2):
                factor = weight * ((1.0 if c == e else 0.0) - direction[c] * direction[e])
                transposed[a + e * m + i, row] -= factor / augmentation
                for j in range(len(transposed)):
                    transposed[j, row] += factor * slips[e * m + i, j]
                rhs[row] -= factor * offsets[e * m + i]


def newton_step(conditions: ContactConditions, state: Iterate, about: Array) -> Solution | None:
    """Tractions and holder position that meet the linearised conditions with each node's status in `state`; None where
    the equations are singular. about: pressures (k,) in MPa at which friction and layers are linearised.
    """
    system, scales, nodes = conditions.system, conditions.scales, conditions.nodes
    compliance, stop = system.compliance, stop_in_play(conditions, state)
    if stop not in conditions.holders:
        conditions.holders[stop] = holder_terms(system, scales.series_compliance, held_place(conditions, stop))
    if state.fresh:
        compliance.know(state.active.nonzero()[0])
    loaded = Loaded(compliance.matrix, compliance.known, compliance.place, compliance.layer)
    laws, holder = conditions.laws(about), conditions.holders[stop]
    transposed, rhs = _equations(loaded, nodes, state, laws, holder, scales)
    solution = _solved(transposed.T, rhs)
    if solution is None:
        return None
    finite, found = _tractions(solution, loaded, nodes, state, laws, scales)
    return found if finite else None


def _solved(matrix: Array, rhs: Array) -> Array | None:
    """The solution (n,) of equations with entries of order one, None where they are singular; overwrites both.

    Many equations are factorised in single precision, which takes half the time, and the solution is improved until it
    is as exact as by double precision (Langou et al., Proc. ACM/IEEE SC (2006) 113).
    """
    if len(rhs) > _FEW:
        factors, pivots, singular = lapack.sgetrf(matrix.astype(np.float32), overwrite_a=1)
        found, left, allowed = np.zeros(len(rhs)), rhs, _LEFT * float(np.abs(rhs).max())
        for _ in range(0 if singular else _IMPROVED):
            found += lapack.sgetrs(factors, pivots, left.astype(np.float32))[0]
            left = rhs - matrix @ found
            if float(np.abs(left).max()) <= allowed:
                return found
    _, _, found, singular = lapack.dgesv(matrix, rhs, overwrite_a=1, overwrite_b=1)
    return None if singular else np.asarray(found)


@inlined
def _scaled(transposed: Array, rhs: Array, scales: Scales, holder: HolderTerms) -> None:
    """Scale equations and unknowns in place to the order of one; `_tractions` scales the unknowns back."""
    size, length = len(rhs), scales.pressure * scales.collective
    row, column = np.full(size, 1.0 / length), np.full(size, scales.pressure)
    column[size - 3] = column[size - 2] = length
    column[size - 1], row[size - 1] = length / scales.reach, scales.reach / length
    row[size - 3] = 1.0 / (holder.normal_load_N if np.isnan(holder.height_mm) else length)
    for j in range(size):
        for i in range(size):
            transposed[j, i] = transposed[j, i] * row[i] * column[j]
    for i in range(size):
        rhs[i] *= row[i]


@inlined
def _numbers(flags: BoolArray) -> IntArray:
    """Indices of the True entries of (k,)."""
    found, used = np.empty(len(flags), np.int64), 0
    for k in range(len(flags)):
        if flags[k]:
            found[used] = k
            used += 1
    return found[:used]


@compiled
def _equations(
    loaded: Loaded, nodes: Nodes, state: Iterate, laws: LinearLaws, holder: HolderTerms, scales: Scales
) -> tuple[Array, Array]:
    """The transposed matrix (size, size) and right-hand side (size,), scaled.

    One compiled function, since passing small arrays from Python to compiled functions costs as much as filling them.
    """
    on, tan, carried = _numbers(state.active), _numbers(state.near_stick), carried_by(nodes, state, laws)
    follow = _numbers(state.follows)
    transposed, rhs = gap_rows(loaded, follow, nodes, carried, laws, on, tan)
    if len(tan) > 0:
        slips, offsets = slip_rows(loaded, follow, nodes, carried, laws, state.tangential, on, tan)
        fill_friction_rows(transposed, rhs, slips, offsets, state, laws, on, tan)
    fill_holder_rows(transposed, rhs, nodes, carried, holder, on, tan)
    _scaled(transposed, rhs, scales, holder)
    return transposed, rhs


@compiled
def _tractions(
    solution: Array, loaded: Loaded, nodes: Nodes, state: Iterate, laws: LinearLaws, scales: Scales
) -> tuple[bool, Solution]:
    """True if a scaled solution (size,) is finite, and the tractions and holder position that it stands for."""
    count, on, tan = len(nodes.areas), _numbers(state.active), _numbers(state.near_stick)
    a, m, length = len(on), len(tan), scales.pressure * scales.collective
    normal, tangential = np.zeros(count), np.zeros((count, 2))
    finite = True
    for i in range(len(solution)):
        finite &= np.isfinite(solution[i])
    for i in range(a):
        normal[on[i]] = solution[i] * scales.pressure
    for k in range(count):
        if state.follows[k]:
            limit = laws.slope[k] * normal[k] + laws.offset[k]
            tangential[k, 0], tangential[k, 1] = limit * state.direction[k, 0], limit * state.direction[k, 1]
    for i in range(m):
        for c in range(2):
            tangential[tan[i], c] = solution[a + c * m + i] * scales.pressure
    force = forces_on(normal, tangential, nodes.frames, loaded.place, loaded.known)
    height, holder_x, tilt = solution[-3] * length, solution[-2] * length, solution[-1] * (length / scales.reach)
    return finite, Solution(force, normal, tangential, height, holder_x, tilt)
