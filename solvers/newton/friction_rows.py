"""Tangential equations of one Newton iteration: zero slip, or friction against it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solvers.newton.carried import Carried
from solvers.newton.conditions import ContactConditions, FrictionStatus, Iterate
from solvers.newton.unknowns import Unknowns

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


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


def slip_growth(
    conditions: ContactConditions, state: Iterate, slip: SlipRows, unknowns: Unknowns, stick: BoolArray
) -> tuple[Array, Array]:
    """Change of the wear work of nodes near stick with the length of their slip, |s| = (s / |s|) . s.

    Far from the solution this derivative misleads, so it waits until nodes no longer change their status.
    """
    tan, system = unknowns.tan, conditions.system
    m = len(tan)
    length = np.linalg.norm(state.slip[tan], axis=1)
    slides = ~stick[tan] & (length > 0.0)
    unit = np.where(slides[:, None], state.slip[tan] / np.maximum(length, 1e-300)[:, None], 0.0)
    limit = system.wear_work.limit(state.normal[tan])
    growth = (unit[:, :1] * slip.rows[:m] + unit[:, 1:] * slip.rows[m:]) * limit[:, None]
    return growth, limit * (unit[:, 0] * slip.offset[:m] + unit[:, 1] * slip.offset[m:] - length * slides)


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
    on, tan = unknowns.on, unknowns.tan
    a, m = len(on), len(tan)
    augmentation = 1.0 / (conditions.tangential_compliance(state.normal)[tan] + conditions.scales.rig)
    column_of = np.full(conditions.count, -1)
    column_of[on] = np.arange(a)
    sticking = friction.stick[tan]
    trial = state.tangential[tan] - augmentation[:, None] * state.slip[tan]
    size = np.maximum(np.linalg.norm(trial, axis=1), 1e-300)
    weight = np.minimum(conditions.system.friction.limit(state.normal[tan]) / size, 1.0)
    slope, constant = carried.slope[tan], carried.offset[tan]
    d = friction.direction[tan]
    index = np.arange(m)
    for c in range(2):
        rows = a + c * m + index
        matrix[rows] = slip.rows[c * m + index]
        rhs[rows] = -slip.offset[c * m + index]
    slipping = np.flatnonzero(~sticking)
    if not len(slipping):
        return
    augmentation = augmentation[slipping]
    local = np.zeros((2, len(slipping), matrix.shape[1]))
    right = np.zeros((2, len(slipping)))
    # In absolute unknowns: q - tau(p) d - weight (1 - d d^T)(q - augmentation s) = 0, times the slip per traction.
    for c in range(2):
        rows = np.arange(len(slipping))
        local[c, rows, a + c * m + slipping] += 1.0
        local[c, rows, column_of[tan[slipping]]] -= slope[slipping] * d[slipping, c]
        right[c] += constant[slipping] * d[slipping, c]
        for e in range(2):
            projector = (1.0 if c == e else 0.0) - d[slipping, c] * d[slipping, e]
            factor = weight[slipping] * projector
            local[c, rows, a + e * m + slipping] -= factor
            local[c] += (factor * augmentation)[:, None] * slip.rows[e * m + slipping]
            right[c] -= factor * augmentation * slip.offset[e * m + slipping]
    for c in range(2):
        matrix[a + c * m + slipping] = local[c] / augmentation[:, None]
        rhs[a + c * m + slipping] = right[c] / augmentation
