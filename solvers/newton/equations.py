"""The linear equations of one Newton iteration, and their solution."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from solvers.compiled import compiled
from solvers.newton.carried import Carried
from solvers.newton.conditions import ContactConditions, FrictionStatus, Iterate
from solvers.newton.friction_rows import fill_friction_rows, slip_rows
from solvers.newton.holder_balance import fill_holder_rows
from solvers.newton.unknowns import Unknowns

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

#: Tractions (k,) and (k, 2) in local frames, then the holder's height, position and tilt.
Solution = tuple[Array, Array, float, float, float]


class NewtonEquations:
    """The equations of a pairing; what they have fetched of its compliance serves all iterations."""

    def __init__(self, conditions: ContactConditions) -> None:
        """Equations of the conditions' linearisations."""
        self.conditions = conditions

    def solution(
        self,
        state: Iterate,
        active: BoolArray,
        friction: FrictionStatus,
        stop: int,
        *,
        layer_pressure: Array,
    ) -> Solution | None:
        """The next tractions and holder position, of nodes of this status; None where the equations are singular.

        layer_pressure: (k,) about which layers are linearised.
        """
        conditions = self.conditions
        unknowns = Unknowns(np.flatnonzero(active), np.flatnonzero(friction.near_stick))
        on, tan, p = unknowns.on, unknowns.tan, unknowns.p
        carried = Carried.along(conditions, state.normal, friction.direction, active & ~friction.near_stick)
        matrix, rhs = np.zeros((unknowns.size, unknowns.size), order="F"), np.zeros(unknowns.size)
        matrix[p, p] = conditions.along(0, on, on, carried.per_normal[on])
        offset = np.zeros(len(on))
        if carried.constant is not None:
            loaded = np.flatnonzero(carried.follows)
            offset += conditions.along(0, on, loaded, carried.constant[loaded]).sum(axis=1)
        if len(tan):
            for c in range(2):
                matrix[p, unknowns.q(c)] = conditions.along(0, on, tan, conditions.tangents[tan, c, :])
            slip = slip_rows(conditions, unknowns, carried, state.tangential, layer_pressure)
            fill_friction_rows(matrix, rhs, conditions, unknowns, slip, state, friction, carried)
        self._add_gaps(matrix, rhs, unknowns, layer_pressure, offset)
        fill_holder_rows(matrix, rhs, conditions, unknowns, carried, stop)
        solution = self._scaled_solve(matrix, rhs, unknowns)
        if solution is None:
            return None
        normal, tangential = np.zeros(conditions.count), np.zeros((conditions.count, 2))
        normal[on] = solution[p]
        follows = carried.follows
        limit = carried.slope[follows] * normal[follows] + carried.offset[follows]
        tangential[follows] = limit[:, None] * friction.direction[follows]
        tangential[tan, 0], tangential[tan, 1] = solution[unknowns.q(0)], solution[unknowns.q(1)]
        return normal, tangential, float(solution[unknowns.z]), float(solution[unknowns.x]), float(solution[unknowns.t])

    def _add_gaps(self, matrix: Array, rhs: Array, unknowns: Unknowns, layer_pressure: Array, offset: Array) -> None:
        """Add to the rows of no gap what the holder's position, the undeformed bodies and the layers contribute, and an
        offset (on,) from elsewhere.
        """
        system, on, p = self.conditions.system, unknowns.on, unknowns.p
        upward, rate = self.conditions.normals[on, 2], system.pairing.gap_rate[on]
        matrix[p, unknowns.z] += upward
        matrix[p, unknowns.x] += upward * rate
        matrix[p, unknowns.t] += upward * system.lever[on]
        rhs[p] = -upward * (system.pairing.gap[on] - rate * system.paired_holder_x) - offset
        if system.layers is not None:
            closure, softness = system.layers.closure(layer_pressure)
            diagonal = np.arange(len(on))
            matrix[diagonal, diagonal] += softness[on]
            rhs[p] -= (closure - softness * layer_pressure)[on]

    def _scaled_solve(self, matrix: Array, rhs: Array, unknowns: Unknowns) -> Array | None:
        """Solution in physical units; rows and columns are scaled in place to be of order one."""
        system, scales = self.conditions.system, self.conditions.scales
        length = scales.pressure * scales.collective
        column = np.full(len(rhs), length)
        column[unknowns.tractions] = scales.pressure
        row = np.full(len(rhs), 1.0 / length)
        # Tilts are measured by what they move at the pivot's height or at the contact's edge, whichever is more.
        reach = max(system.holder.pivot_height_mm, float(self.conditions.areas.sum()) ** 0.5)
        column[unknowns.t], row[unknowns.t] = length / reach, reach / length
        row[unknowns.z] = 1.0 / (system.holder.normal_load_N if system.prescribed_height is None else length)
        _scale(matrix.T, row, column)
        _, _, solution, info = lapack.dgesv(matrix, row * rhs, overwrite_a=1)
        if info != 0 or not np.all(np.isfinite(solution)):
            return None
        return np.asarray(solution * column)


@compiled
def _scale(transposed: Array, row: Array, column: Array) -> None:
    """Scale a matrix, given as its transpose, by rows and columns in place."""
    for j in range(transposed.shape[0]):
        for i in range(transposed.shape[1]):
            transposed[j, i] = transposed[j, i] * row[i] * column[j]
