"""The linear equations of one Newton iteration, and their solution.

Gaps and slips of nodes in the equations of one Newton iteration: what unknown tractions and the holder do to them.

Unknowns stand in this order: normal tractions of the nodes `on` (a,), those along the first and along the second
tangent of the nodes `tan` (m,), then the holder's height, position and tilt. Rows stand in the same order: no gap, no
slip or the friction law, the holder's equilibrium. Matrices are filled transposed, as LAPACK wants them.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack

from geometry.arrays import Array, BoolArray, IntArray
from solvers.kept_code import compiled, inlined
from solvers.newton.conditions import ContactConditions, FrictionStatus, Iterate, fill_holder_rows, held_place
from solvers.newton.terms import (
    Carried,
    FrictionTerms,
    HolderTerms,
    LayerTerms,
    Nodes,
    carried_by,
    holder_terms,
    layer_terms,
)


class Loaded(NamedTuple):
    """What tractions on nodes do, see `PairedCompliance`: columns of `matrix` at a node's `place`; the layer's compliance.

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
    """Write the displacement of a node along an axis of its frame by unit tractions on all nodes that have columns."""
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


#: Tractions (k,) and (k, 2) in local frames, then the holder's height, position and tilt.
Solution = tuple[Array, Array, float, float, float]


@inlined
def fill_friction_rows(
    transposed: Array, rhs: Array, slips: Array, offsets: Array, friction: FrictionTerms, on: IntArray, tan: IntArray
) -> None:
    """Write the rows of the nodes near stick: zero slip, or the linearised projection onto the friction cone.

    slips, offsets: of these nodes, see `slip_rows`.  In absolute unknowns the projection reads
    q - tau(p) d - weight (1 - d d^T)(q - augmentation s) = 0, here times the slip per traction.
    """
    a, m = len(on), len(tan)
    column = np.full(len(friction.limit), -1)
    for i in range(a):
        column[on[i]] = i
    for i in range(m):
        node = tan[i]
        augmentation, direction = friction.augmentation[node], friction.direction[node]
        trial_0 = friction.tangential[node, 0] - augmentation * friction.slip[node, 0]
        trial_1 = friction.tangential[node, 1] - augmentation * friction.slip[node, 1]
        size = max(np.sqrt(trial_0**2 + trial_1**2), 1e-300)
        weight = min(friction.limit[node] / size, 1.0)
        for c in range(2):
            row = a + c * m + i
            if friction.stick[node]:
                for j in range(len(transposed)):
                    transposed[j, row] = slips[c * m + i, j]
                rhs[row] = -offsets[c * m + i]
                continue
            transposed[row, row] = 1.0 / augmentation
            transposed[column[node], row] = -friction.slope[node] * direction[c] / augmentation
            rhs[row] = friction.offset[node] * direction[c] / augmentation
            for e in range(2):
                factor = weight * ((1.0 if c == e else 0.0) - direction[c] * direction[e])
                transposed[a + e * m + i, row] -= factor / augmentation
                for j in range(len(transposed)):
                    transposed[j, row] += factor * slips[e * m + i, j]
                rhs[row] -= factor * offsets[e * m + i]


class Sizes(NamedTuple):
    """By what unknowns and rows are scaled: traction, displacement, the displacement by a tilt of 1, and the load.

    In MPa, mm, mm and N; load_N: NaN where the holder's height is prescribed.
    """

    pressure: float
    length: float
    reach: float
    load_N: float


def newton_step(
    conditions: ContactConditions,
    state: Iterate,
    active: BoolArray,
    friction: FrictionStatus,
    stop: int,
    *,
    about: Array,
) -> Solution | None:
    """The next tractions and holder position, of nodes of this status; None where the equations are singular.

    about: pressures (k,) about which friction and layers are linearised.
    """
    system, scales, nodes = conditions.system, conditions.scales, conditions.nodes
    slope, offset = system.friction.tangent(about)
    terms = FrictionTerms(
        stick=friction.stick,
        follows=friction.follows,
        direction=friction.direction,
        limit=friction.limit,
        slope=slope,
        offset=offset,
        augmentation=friction.augmentation,
        tangential=state.tangential,
        slip=state.slip,
    )
    on, tan = active.nonzero()[0], friction.near_stick.nonzero()[0]
    compliance = system.compliance
    compliance.know(on)
    follow = terms.follows.nonzero()[0]
    if stop not in conditions.holders:
        conditions.holders[stop] = holder_terms(system, scales.series_compliance, held_place(conditions, stop))
    loaded = Loaded(compliance.matrix, compliance.known, compliance.place, compliance.layer, follow)
    layers, holder = layer_terms(system, about), conditions.holders[stop]
    transposed, rhs, column = _equations(loaded, nodes, terms, layers, holder, _sizes(conditions), on, tan)
    _, _, solution, info = lapack.dgesv(transposed.T, rhs, overwrite_a=1, overwrite_b=1)
    if info != 0:
        return None
    finite, normal, tangential, height, holder_x, tilt = _tractions(solution, column, terms, on, tan)
    return (normal, tangential, height, holder_x, tilt) if finite else None


def _sizes(conditions: ContactConditions) -> Sizes:
    system, scales = conditions.system, conditions.scales
    # Tilts are measured by what they move at the pivot's height or at the contact's edge, whichever is more.
    reach = max(system.holder.pivot_height_mm, float(conditions.areas.sum()) ** 0.5)
    load = system.holder.normal_load_N if system.prescribed_height is None else np.nan
    return Sizes(scales.pressure, scales.pressure * scales.collective, reach, load)


@inlined
def _scaled(transposed: Array, rhs: Array, sizes: Sizes) -> Array:
    """Scale equations in place to be of order one; what the unknowns are measured by, (size,)."""
    size = len(rhs)
    row, column = np.full(size, 1.0 / sizes.length), np.full(size, sizes.pressure)
    column[size - 3] = column[size - 2] = sizes.length
    column[size - 1], row[size - 1] = sizes.length / sizes.reach, sizes.reach / sizes.length
    row[size - 3] = 1.0 / (sizes.length if np.isnan(sizes.load_N) else sizes.load_N)
    for j in range(size):
        for i in range(size):
            transposed[j, i] = transposed[j, i] * row[i] * column[j]
    for i in range(size):
        rhs[i] *= row[i]
    return column


@compiled
def _equations(
    loaded: Loaded,
    nodes: Nodes,
    friction: FrictionTerms,
    layers: LayerTerms,
    holder: HolderTerms,
    sizes: Sizes,
    on: IntArray,
    tan: IntArray,
) -> tuple[Array, Array, Array]:
    """The transposed matrix (size, size) and right-hand side (size,), scaled, and what unknowns are measured by.

    In one piece, for handing small arrays over between Python and compiled functions costs as much as filling them.
    """
    carried = carried_by(nodes, friction)
    transposed, rhs = gap_rows(loaded, nodes, carried, layers, on, tan)
    if len(tan) > 0:
        slips, offsets = slip_rows(loaded, nodes, carried, layers, friction.tangential, on, tan)
        fill_friction_rows(transposed, rhs, slips, offsets, friction, on, tan)
    fill_holder_rows(transposed, rhs, nodes, carried, holder, on, tan)
    return transposed, rhs, _scaled(transposed, rhs, sizes)


@compiled
def _tractions(
    solution: Array, column: Array, friction: FrictionTerms, on: IntArray, tan: IntArray
) -> tuple[bool, Array, Array, float, float, float]:
    """Whether a scaled solution is finite, tractions (k,) and (k, 2), and the holder's height, position and tilt."""
    count, a, m = len(friction.limit), len(on), len(tan)
    normal, tangential = np.zeros(count), np.zeros((count, 2))
    finite = True
    for i in range(len(solution)):
        finite &= np.isfinite(solution[i])
    for i in range(a):
        normal[on[i]] = solution[i] * column[i]
    for k in range(count):
        if friction.follows[k]:
            limit = friction.slope[k] * normal[k] + friction.offset[k]
            tangential[k, 0], tangential[k, 1] = limit * friction.direction[k, 0], limit * friction.direction[k, 1]
    for i in range(m):
        for c in range(2):
            tangential[tan[i], c] = solution[a + c * m + i] * column[a + c * m + i]
    height, holder_x, tilt = solution[-3] * column[-3], solution[-2] * column[-2], solution[-1] * column[-1]
    return finite, normal, tangential, height, holder_x, tilt
