"""Tangential equations of one Newton iteration: zero slip, or friction against it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solvers.compiled import compiled
from solvers.newton.carried import Carried
from solvers.newton.conditions import ContactConditions, FrictionStatus, Iterate
from solvers.newton.unknowns import Unknowns

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class SlipRows:
    """Slip of the m nodes with tangential unknowns along both tangents: rows (2 m, unknowns), constant part (2 m,)."""

    rows: Array
    offset: Array


def slip_rows(
    conditions: ContactConditions,
    unknowns: Unknowns,
    carried: Carried,
    tangential: Array,
    layer_pressure: Array,
) -> SlipRows:
    """Slip of the nodes near stick, with layers linearised about tractions (k, 2) and pressures (k,).

    carried: tractions of the nodes by their normal ones.
    """
    system, on, tan = conditions.system, unknowns.on, unknowns.tan
    a, m = len(on), len(tan)
    tangents = (conditions.tangents[tan, 0, :], conditions.tangents[tan, 1, :])
    both, double = np.concatenate(tangents), np.concatenate([tan, tan])
    rows = np.zeros((2 * m, unknowns.size))
    for axis in (1, 2):
        part = slice((axis - 1) * m, axis * m)
        rows[part, unknowns.p] = conditions.along(axis, tan, on, carried.per_normal[on])
        for c in range(2):
            rows[part, unknowns.q(c)] = conditions.along(axis, tan, tan, tangents[c])
    rows[:, unknowns.z], rows[:, unknowns.x] = both[:, 2], both[:, 0]
    rows[:, unknowns.t] = both[:, 2] * system.lever[double]
    rigid = np.zeros((2 * m, 3))
    rigid[:, 0] = -system.old_holder_x - system.drive_step
    rigid[:, 2] = -system.old_height - system.lever[double] * system.old_tilt
    offset = np.einsum("ij,ij->i", both, rigid - system.old_displacement[double])
    if carried.constant is not None:
        loaded = np.flatnonzero(carried.follows)
        for axis in (1, 2):
            moved = conditions.along(axis, tan, loaded, carried.constant[loaded])
            offset[(axis - 1) * m : axis * m] += moved.sum(axis=1)
    if system.layers is not None:
        compliance, change = system.layers.shear_compliance(layer_pressure)
        index = np.arange(2 * m)
        rows[index, a + index] += compliance[double]
        change = change[double] * tangential[tan].T.ravel()
        rows[index, np.searchsorted(on, double)] += change
        offset -= change * layer_pressure[double]
        offset -= np.einsum("ij,ij->i", both, system.layers.old_displacement[double])
    return SlipRows(rows, offset)


def fill_friction_rows(
    matrix: Array,
    rhs: Array,
    conditions: ContactConditions,
    unknowns: Unknowns,
    slip: SlipRows,
    state: Iterate,
    friction: FrictionStatus,
    carried: Carried,
) -> None:
    """Write the rows of the nodes near stick: zero slip, or the linearised projection onto the friction cone."""
    tan = unknowns.tan
    column_of = np.full(conditions.count, -1)
    column_of[unknowns.on] = np.arange(len(unknowns.on))
    _fill(
        matrix,
        rhs,
        slip.rows,
        slip.offset,
        friction.stick[tan],
        column_of[tan],
        state.tangential[tan],
        state.slip[tan],
        conditions.system.friction.limit(state.normal)[tan],
        1.0 / (conditions.tangential_compliance(state.normal)[tan] + conditions.scales.rig),
        friction.direction[tan],
        carried.slope[tan],
        carried.offset[tan],
        len(unknowns.on),
    )


@compiled
def _fill(
    matrix: Array,
    rhs: Array,
    slip_rows: Array,
    slip_offset: Array,
    stick: BoolArray,
    column: IntArray,
    tangential: Array,
    slip: Array,
    limit: Array,
    augmentation: Array,
    direction: Array,
    slope: Array,
    constant: Array,
    first: int,
) -> None:
    """In absolute unknowns q - tau(p) d - weight (1 - d d^T)(q - augmentation s) = 0, times the slip per traction."""
    m = len(stick)
    for i in range(m):
        trial = tangential[i] - augmentation[i] * slip[i]
        size = max(np.sqrt(trial[0] ** 2 + trial[1] ** 2), 1e-300)
        weight = min(limit[i] / size, 1.0)
        for c in range(2):
            row = first + c * m + i
            if stick[i]:
                matrix[row] = slip_rows[c * m + i]
                rhs[row] = -slip_offset[c * m + i]
                continue
            matrix[row] = 0.0
            matrix[row, row] = 1.0 / augmentation[i]
            matrix[row, column[i]] = -slope[i] * direction[i, c] / augmentation[i]
            rhs[row] = constant[i] * direction[i, c] / augmentation[i]
            for e in range(2):
                factor = weight * ((1.0 if c == e else 0.0) - direction[i, c] * direction[i, e])
                matrix[row, first + e * m + i] -= factor / augmentation[i]
                matrix[row] += factor * slip_rows[e * m + i]
                rhs[row] -= factor * slip_offset[e * m + i]
