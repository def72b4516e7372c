"""The linear equations of one Newton iteration, and their solution."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from solvers.newton.conditions import ContactConditions, FrictionStatus, Iterate
from solvers.newton.friction_rows import fill_friction_rows, slip_growth, slip_rows
from solvers.newton.holder_balance import fill_holder_rows
from solvers.newton.unit_responses import UnitResponses
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
        self._responses = UnitResponses(conditions.system)

    def solution(
        self,
        state: Iterate,
        active: BoolArray,
        friction: FrictionStatus,
        stop: int,
        *,
        layer_pressure: Array,
        settled: bool,
    ) -> Solution | None:
        """The next tractions and holder position, of nodes of this status; None where the equations are singular.

        layer_pressure: (k,) about which layers are linearised.  settled: nodes no longer change their status.
        """
        conditions, system, mu = self.conditions, self.conditions.system, self.conditions.system.friction
        unknowns = Unknowns(np.flatnonzero(active), np.flatnonzero(friction.near_stick))
        on, tan, p = unknowns.on, unknowns.tan, unknowns.p
        follows = active & ~friction.near_stick
        carried = self._carried(friction.direction, follows)
        matrix, rhs = np.zeros((unknowns.size, unknowns.size), order="F"), np.zeros(unknowns.size)
        matrix[p, p] = self._responses.along(0, on, on, carried[on])
        if system.wear_gap is not None:
            slip_length = np.linalg.norm(state.slip, axis=1)
            worn = np.where(active & ~friction.stick, system.wear_work_per_load_and_slip * slip_length, 0.0)
            recession = (conditions.normals[on, 2] * (1.0 / conditions.areas)[on])[:, None] * system.wear_gap[on]
            matrix[p, p] += recession[:, on] * worn[on]
        worn_offset: Array | float = 0.0
        if len(tan):
            for c in range(2):
                matrix[p, unknowns.q(c)] = self._responses.along(0, on, tan, conditions.tangents[tan, c, :])
            slip = slip_rows(conditions, self._responses, unknowns, carried, state.tangential, layer_pressure)
            fill_friction_rows(matrix, rhs, conditions, unknowns, slip, state, friction)
            if system.wear_gap is not None and settled:
                growth, constant = slip_growth(conditions, state, slip, unknowns, friction.stick)
                matrix[p] += recession[:, tan] @ growth
                worn_offset = recession[:, tan] @ constant
        self._add_gaps(matrix, rhs, unknowns, layer_pressure, worn_offset)
        fill_holder_rows(matrix, rhs, conditions, unknowns, carried, stop)
        solution = self._scaled_solve(matrix, rhs, unknowns)
        if solution is None:
            return None
        normal, tangential = np.zeros(conditions.count), np.zeros((conditions.count, 2))
        normal[on] = solution[p]
        tangential[follows] = mu * normal[follows, None] * friction.direction[follows]
        tangential[tan, 0], tangential[tan, 1] = solution[unknowns.q(0)], solution[unknowns.q(1)]
        return normal, tangential, float(solution[unknowns.z]), float(solution[unknowns.x]), float(solution[unknowns.t])

    def _carried(self, direction: Array, follows: BoolArray) -> Array:
        """Traction of each node in world axes by unit normal traction, friction included where it follows a known
        direction, (k, 3).
        """
        conditions = self.conditions
        t1, t2 = conditions.tangents[:, 0, :], conditions.tangents[:, 1, :]
        along = direction[:, :1] * t1 + direction[:, 1:] * t2
        return np.asarray(conditions.normals + np.where(follows, conditions.system.friction, 0.0)[:, None] * along)

    def _add_gaps(
        self, matrix: Array, rhs: Array, unknowns: Unknowns, layer_pressure: Array, worn_offset: Array | float
    ) -> None:
        """Add to the rows of no gap what the holder's position, the undeformed bodies and the layers contribute."""
        system, on, p = self.conditions.system, unknowns.on, unknowns.p
        upward, rate = self.conditions.normals[on, 2], system.pairing.gap_rate[on]
        matrix[p, unknowns.z] += upward
        matrix[p, unknowns.x] += upward * rate
        matrix[p, unknowns.t] += upward * system.lever[on]
        rhs[p] = -upward * (system.pairing.gap[on] - rate * system.paired_holder_x) - worn_offset
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
        matrix *= row[:, None]
        matrix *= column
        _, _, solution, info = lapack.dgesv(matrix, row * rhs, overwrite_a=1)
        if info != 0 or not np.all(np.isfinite(solution)):
            return None
        return np.asarray(solution * column)
