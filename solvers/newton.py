"""Semismooth Newton method for the contact conditions of one pairing of two surfaces.

Per node j, with normal traction p, tangential traction q, mean gap g and mean slip s of the upper body against the
lower one over the increment:
    open: p = q = 0, g >= 0;  stick: g = 0, s = 0, |q| <= mu p;  slip: g = 0, q = -mu p s / |s|.
The augmentation that decides between stick and slip is scaled with the whole compliance that a change of friction
meets, the rig's included; with the local one alone a soft rig makes nodes alternate between both slip directions.
Free play of the holder is one more such alternative: it floats without force, or rests on either stop.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from solvers.contact_system import LOST_CONTACT, Linearisation, NewtonOutcome

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

_MOST_ITERATIONS = 60
# Iterations without progress after which the increment is given up.
_PATIENCE = 15
#: Allowed gap of loaded nodes over the largest elastic displacement, and unbalanced force over the load.
_GAP_TOLERANCE = 1e-5
#: Allowed angle between friction and slip, rad.
_DIRECTION_TOLERANCE = 1e-4
# Slipping nodes keep their tangential unknowns while their slip is below this share of the displacement that full
# friction on all nodes would cause; beyond, iterating the direction converges fast.
_NEAR_STICK = 2.0
# Layers stiffen with the pressure: linearised where it is high, they ask for less than nothing where it should be low.
_LARGEST_FALL = 0.2
# Fewer nodes than this do not describe a contact.
_FEW_NODES = 10
_MESH_TOO_COARSE = "most likely the mesh is too coarse for this contact: take a smaller contact_mesh_um"


class _KnownResponse:
    """Displacement of some of k nodes along a direction by unit tractions on all, as far as it has been needed."""

    def __init__(self, count: int) -> None:
        self.place = np.full(count, -1)
        self.columns = 0
        self.response = np.empty((3, count, 0))

    def append(self, nodes: IntArray, response: Array) -> None:
        """Add the response (3, k, m) of further nodes (m,)."""
        self.place[nodes] = self.columns + np.arange(len(nodes))
        self.columns += len(nodes)
        self.response = np.concatenate([self.response, response], axis=2) if self.response.size else response

    def under(self, nodes: IntArray, loaded: IntArray, vectors: Array) -> Array:
        """Displacement of `nodes` by tractions on each loaded node along its vector (l, 3), shape (nodes, l)."""
        total: Array = vectors[:, :1] * self.response[0, loaded]
        for c in (1, 2):
            total += vectors[:, c : c + 1] * self.response[c, loaded]
        chosen = self.place[nodes]
        if len(chosen) != self.columns or np.any(np.diff(chosen) != 1):
            total = total[:, chosen]
        return total.T


@dataclass
class _Iterate:
    """Current tractions in local frames, holder position, and what follows from them."""

    normal: Array
    tangential: Array
    height: float
    holder_x: float
    tilt: float
    gap: Array
    slip: Array
    elastic: float


def solve_contact(
    system: Linearisation, traction: Array, active: BoolArray, height: float, holder_x: float
) -> NewtonOutcome:
    """Solve the contact conditions from a guess of tractions (k, 3), nodes in contact (k,) and holder position."""
    return _ContactNewton(system).solve(traction, active, height, holder_x)


def _likeliest_cause(active: BoolArray, opening: BoolArray, sticking: BoolArray) -> str:
    """What most probably keeps an increment from converging, as part of a sentence."""
    if active.sum() < _FEW_NODES:
        return _MESH_TOO_COARSE
    if sticking.sum() > opening.sum():
        return (
            "most likely the nodes flicker between stick and slip because the increments are long against the elastic "
            "motion: take more increments_per_cycle"
        )
    if opening.any():
        return (
            "most likely the contact's edge flickers because one increment wears or moves the surfaces too far: take a "
            "smaller jump_tolerance or more increments_per_cycle"
        )
    return "most likely the direction of slip turns too far within the increment: take more increments_per_cycle"


class _ContactNewton:
    def __init__(self, system: Linearisation) -> None:
        self.system = system
        pairing = system.pairing
        self.normals = pairing.frames[:, 0, :]
        self.tangents = pairing.frames[:, 1:, :]
        self.areas = pairing.areas
        self.count = len(pairing.nodes)
        self._known: dict[int, _KnownResponse] = {}
        self.settled = False

    def solve(self, traction: Array, active: BoolArray, height: float, holder_x: float) -> NewtonOutcome:
        system = self.system
        if system.prescribed_height is not None:
            height = system.prescribed_height
        normal = np.maximum(np.einsum("ij,ij->i", traction, self.normals), 0.0)
        tangential = np.einsum("ij,ikj->ik", traction, self.tangents)
        self.layer_pressure = normal
        self._scale(active)
        state = self._evaluate(normal, tangential, height, holder_x, system.old_tilt)
        stick, near, direction = self._friction_status(state, active)
        stop = self._stop(state)
        best, best_at = np.inf, 0
        message = "no iteration was made"
        for iteration in range(1, _MOST_ITERATIONS + 1):
            if not active.any():
                return self._failure(state, iteration, LOST_CONTACT)
            solution = self._linear_solution(state, active, stick, near, direction, stop)
            if solution is None:
                singular = f"the contact's equations became singular with {int(active.sum())} nodes in contact"
                return self._failure(state, iteration, f"{singular}; {_MESH_TOO_COARSE}")
            state = self._evaluate(*solution)
            self.layer_pressure = np.maximum(state.normal, _LARGEST_FALL * self.layer_pressure)
            new_active = state.normal - self._normal_augmentation(state.normal) * state.gap > 0.0
            new_stick, new_near, new_direction = self._friction_status(state, new_active)
            new_stop = self._stop(state)
            slipping = active & ~stick
            turn = np.linalg.norm(new_direction - direction, axis=1)[slipping & (state.normal > 0.0)]
            settled = np.array_equal(new_active, active) and np.array_equal(new_stick, stick) and new_stop == stop
            self.settled = settled
            gap_error = float(np.abs(state.gap[active]).max()) / max(state.elastic, 1e-300)
            turned = float(turn.max()) if len(turn) else 0.0
            if settled and gap_error <= _GAP_TOLERANCE and turned <= _DIRECTION_TOLERANCE:
                return self._outcome(state, active, stick, direction, iteration)
            message = (
                f"after {iteration} iterations {int((new_active ^ active).sum())} nodes still open or close, "
                f"{int((new_stick ^ stick).sum())} change between stick and slip, the largest gap error is "
                f"{gap_error:.1e} and the slip direction turns by {turned:.1e} rad"
            )
            error = (
                max(gap_error, turned) if settled else 1.0 + float(((new_active ^ active) | (new_stick ^ stick)).sum())
            )
            if error < 0.9 * best:
                best, best_at = error, iteration
            elif iteration - best_at > _PATIENCE:
                break
            active, stick, near, direction, stop = new_active, new_stick, new_near, new_direction, new_stop
        cause = _likeliest_cause(active, new_active ^ active, new_stick ^ stick)
        return self._failure(state, iteration, f"{message}; {cause}")

    def _scale(self, loaded: BoolArray) -> None:
        """Collective compliance (mm per MPa) of the contact, which scales all augmentation parameters."""
        nodes = loaded if loaded.any() else np.ones(self.count, dtype=bool)
        uniform = np.where(nodes[:, None], self.normals, 0.0)
        lift = np.einsum("ij,ij->i", self.system.compliance.displacement(uniform), self.normals)
        self.collective = float(lift[nodes].max())
        self.local = self.collective / max(1.0, 0.5 * float(np.sqrt(nodes.sum())))
        area = float(self.areas[nodes].sum())
        rig = self.system.holder.compliance_at_contact_mm_per_N * area
        self.rig = rig
        self.series_compliance = (self.collective + rig) / area
        self.pressure = self.system.holder.normal_load_N / area

    def _tangential_compliance(self, normal: Array) -> Array:
        """Displacement of each node per tangential traction on all of them, mm per MPa, (k,); the rig's apart."""
        layers = self.system.layers
        return self.collective + (np.zeros(self.count) if layers is None else layers.shear_compliance(normal)[0])

    def _normal_augmentation(self, normal: Array) -> Array | float:
        """Pressure per gap, MPa per mm, by which nodes open or close."""
        layers = self.system.layers
        return 1.0 / self.local if layers is None else 1.0 / (self.local + layers.closure(normal)[1])

    def _response(self, axis: int, nodes: IntArray, loaded: IntArray, vectors: Array) -> Array:
        """Displacement of `nodes` along their normal (axis 0) or a tangent by unit tractions along vectors (l, 3).

        The (nodes, l) result is in Fortran order.
        """
        if axis not in self._known:
            self._known[axis] = _KnownResponse(self.count)
        known = self._known[axis]
        missing = nodes[known.place[nodes] < 0]
        if len(missing):
            frames = self.system.pairing.frames[missing, axis, :]
            known.append(missing, self.system.compliance.by_unit_tractions(missing, frames))
        return known.under(nodes, loaded, vectors)

    def _world(self, normal: Array, tangential: Array) -> Array:
        return np.asarray(normal[:, None] * self.normals + np.einsum("ik,ikj->ij", tangential, self.tangents))

    def _evaluate(self, normal: Array, tangential: Array, height: float, holder_x: float, tilt: float) -> _Iterate:
        system, pairing = self.system, self.system.pairing
        elastic = system.compliance.displacement(self._world(normal, tangential))
        rigid = np.zeros((self.count, 3))
        rigid[:, 0] = holder_x - system.old_holder_x - system.drive_step
        rigid[:, 2] = height - system.old_height + system.lever * (tilt - system.old_tilt)
        slip = np.einsum("ij,ikj->ik", elastic - system.old_displacement + rigid, self.tangents)
        gap = self.normals[:, 2] * (
            pairing.gap + height + system.lever * tilt + pairing.gap_rate * (holder_x - system.paired_holder_x)
        ) + np.einsum("ij,ij->i", elastic, self.normals)
        if system.layers is not None:
            gap = gap + system.layers.closure(normal)[0]
            sheared = system.layers.shear_compliance(normal)[0][:, None] * tangential
            slip = slip + sheared - np.einsum("ij,ikj->ik", system.layers.old_displacement, self.tangents)
        if system.wear_gap is not None:
            gap = gap + self.normals[:, 2] * (system.wear_gap @ self._wear_work(normal, tangential, slip)) / self.areas
        return _Iterate(normal, tangential, height, holder_x, tilt, gap, slip, float(np.abs(elastic).max()))

    def _wear_work(self, normal: Array, tangential: Array, slip: Array) -> Array:
        """Wear work per plane area of the nodes that slide."""
        sliding = np.linalg.norm(tangential, axis=1) >= self.system.friction * normal * (1.0 - 1e-9)
        work = self.system.wear_work_per_load_and_slip * normal * np.linalg.norm(slip, axis=1)
        return np.where(sliding, work, 0.0)

    def _friction_status(self, state: _Iterate, active: BoolArray) -> tuple[BoolArray, BoolArray, Array]:
        """Sticking nodes, those that keep tangential unknowns, and directions of friction (k, 2)."""
        limit = self.system.friction * np.maximum(state.normal, 0.0)
        slip = np.linalg.norm(state.slip, axis=1)
        compliance = self._tangential_compliance(state.normal)
        trial = state.tangential - (1.0 / (compliance + self.rig))[:, None] * state.slip
        size = np.linalg.norm(trial, axis=1)
        if self.system.friction == 0.0:
            return np.zeros_like(active), np.zeros_like(active), np.zeros((self.count, 2))
        stick = active & (size <= limit)
        near = active & (stick | (slip < _NEAR_STICK * limit * compliance))
        direction = np.zeros((self.count, 2))
        direction[:, 0] = np.sign(self.system.drive_step)
        moving = size > 0.0
        direction[moving] = trial[moving] / size[moving, None]
        # Far from stick the slip alone gives the direction; the trial traction would turn into it only slowly.
        far = active & ~near & (np.einsum("ij,ij->i", trial, state.slip) < 0.0) & (slip > 0.0)
        direction[far] = -state.slip[far] / slip[far, None]
        return stick, near, direction

    def _stop(self, state: _Iterate) -> int:
        """Which stop of its free play the holder rests on: +1 or -1, or 0 while it floats between them."""
        holder = self.system.holder
        if holder.play_mm == 0.0:
            return 0
        force = float(self.areas @ self._world(state.normal, state.tangential)[:, 0])
        place = holder.place_in_play_mm(state.holder_x, state.tilt, force)
        # On a stop the place is the stop's, floating the force is zero: the compliance between them only has to be
        # positive.
        trial = place + self.series_compliance * force
        return int(trial > 0.5 * holder.play_mm) - int(trial < -0.5 * holder.play_mm)

    def _held_place(self, stop: int) -> float | None:
        """Where in its free play the holder is held, mm; None while it floats."""
        if self.system.holder.play_mm == 0.0:
            return 0.0
        if self.system.friction == 0.0:
            # Nothing else would hold it.
            return self.system.old_place_in_play
        return 0.5 * stop * self.system.holder.play_mm if stop else None

    def _linear_solution(
        self, state: _Iterate, active: BoolArray, stick: BoolArray, near: BoolArray, direction: Array, stop: int
    ) -> tuple[Array, Array, float, float, float] | None:
        system, mu = self.system, self.system.friction
        on, tan = np.flatnonzero(active), np.flatnonzero(near)
        follows = active & ~near
        a, m = len(on), len(tan)
        t1, t2 = self.tangents[:, 0, :], self.tangents[:, 1, :]
        along = direction[:, :1] * t1 + direction[:, 1:] * t2
        carried = self.normals + np.where(follows, mu, 0.0)[:, None] * along
        size = a + 2 * m + 3
        matrix, rhs = np.zeros((size, size), order="F"), np.zeros(size)
        z, x, t = size - 3, size - 2, size - 1
        p, q1, q2 = slice(0, a), slice(a, a + m), slice(a + m, a + 2 * m)
        inverse_area = 1.0 / self.areas
        matrix[p, p] = self._response(0, on, on, carried[on])
        slip_length = np.linalg.norm(state.slip, axis=1)
        if system.wear_gap is not None:
            worn = np.where(active & ~stick, system.wear_work_per_load_and_slip * slip_length, 0.0)
            recession = (self.normals[on, 2] * inverse_area[on])[:, None] * system.wear_gap[on]
            matrix[p, p] += recession[:, on] * worn[on]
        worn_offset: Array | float = 0.0
        if m:
            matrix[p, q1] = self._response(0, on, tan, t1[tan])
            matrix[p, q2] = self._response(0, on, tan, t2[tan])
            slip_rows, offset = self._slip_rows(on, tan, carried, state.tangential)
            self._stick_or_slip_rows(matrix, rhs, slip_rows, offset, state, on, tan, stick, direction)
            if system.wear_gap is not None and self.settled:
                growth, constant = self._slip_growth(state, slip_rows, offset, tan, stick)
                matrix[p] += recession[:, tan] @ growth
                worn_offset = recession[:, tan] @ constant
        upward, rate = self.normals[on, 2], system.pairing.gap_rate[on]
        matrix[p, z] += upward
        matrix[p, x] += upward * rate
        matrix[p, t] += upward * system.lever[on]
        rhs[p] = -upward * (system.pairing.gap[on] - rate * system.paired_holder_x) - worn_offset
        if system.layers is not None:
            closure, softness = system.layers.closure(self.layer_pressure)
            matrix[np.arange(a), np.arange(a)] += softness[on]
            rhs[p] -= (closure - softness * self.layer_pressure)[on]
        self._holder_rows(matrix, rhs, on, tan, carried, stop)
        solution = self._scaled_solve(matrix, rhs, a + 2 * m)
        if solution is None:
            return None
        normal, tangential = np.zeros(self.count), np.zeros((self.count, 2))
        normal[on] = solution[p]
        tangential[follows] = mu * normal[follows, None] * direction[follows]
        tangential[tan, 0], tangential[tan, 1] = solution[q1], solution[q2]
        return normal, tangential, float(solution[z]), float(solution[x]), float(solution[t])

    def _slip_rows(self, on: IntArray, tan: IntArray, carried: Array, tangential: Array) -> tuple[Array, Array]:
        """Slip of the nodes `tan` along both tangents, (2 m, unknowns), and its constant part, (2 m,)."""
        system = self.system
        a, m = len(on), len(tan)
        tangents = (self.tangents[tan, 0, :], self.tangents[tan, 1, :])
        both, double = np.concatenate(tangents), np.concatenate([tan, tan])
        rows = np.zeros((2 * m, a + 2 * m + 3))
        for axis in (1, 2):
            part = slice((axis - 1) * m, axis * m)
            rows[part, :a] = self._response(axis, tan, on, carried[on])
            for c in range(2):
                rows[part, a + c * m : a + (c + 1) * m] = self._response(axis, tan, tan, tangents[c])
        rows[:, -3], rows[:, -2], rows[:, -1] = both[:, 2], both[:, 0], both[:, 2] * system.lever[double]
        rigid = np.zeros((2 * m, 3))
        rigid[:, 0] = -system.old_holder_x - system.drive_step
        rigid[:, 2] = -system.old_height - system.lever[double] * system.old_tilt
        offset = np.einsum("ij,ij->i", both, rigid - system.old_displacement[double])
        if system.layers is not None:
            compliance, change = system.layers.shear_compliance(self.layer_pressure)
            index = np.arange(2 * m)
            rows[index, a + index] += compliance[double]
            change = change[double] * tangential[tan].T.ravel()
            rows[index, np.searchsorted(on, double)] += change
            offset -= change * self.layer_pressure[double]
            offset -= np.einsum("ij,ij->i", both, system.layers.old_displacement[double])
        return rows, offset

    def _slip_growth(
        self, state: _Iterate, slip_rows: Array, offset: Array, tan: IntArray, stick: BoolArray
    ) -> tuple[Array, Array]:
        """Change of the wear work of nodes near stick with the length of their slip, |s| = (s / |s|) . s.

        Far from the solution this derivative misleads, so it waits until nodes no longer change their status.
        """
        m = len(tan)
        length = np.linalg.norm(state.slip[tan], axis=1)
        slides = ~stick[tan] & (length > 0.0)
        unit = np.where(slides[:, None], state.slip[tan] / np.maximum(length, 1e-300)[:, None], 0.0)
        limit = self.system.wear_work_per_load_and_slip * np.maximum(state.normal[tan], 0.0)
        growth = (unit[:, :1] * slip_rows[:m] + unit[:, 1:] * slip_rows[m:]) * limit[:, None]
        return growth, limit * (unit[:, 0] * offset[:m] + unit[:, 1] * offset[m:] - length * slides)

    def _holder_rows(self, matrix: Array, rhs: Array, on: IntArray, tan: IntArray, carried: Array, stop: int) -> None:
        """Equilibrium of the holder: tractions against the load, and against the rig's springs."""
        system, w, holder = self.system, self.areas, self.system.holder
        a, m, size = len(on), len(tan), len(rhs)
        z, x, t = size - 3, size - 2, size - 1
        for row, axis in ((z, 2), (x, 0)):
            matrix[row, :a] = w[on] * carried[on, axis]
            for c in range(2):
                matrix[row, a + c * m : a + (c + 1) * m] = w[tan] * self.tangents[tan, c, axis]
        lever = np.concatenate([system.lever[on], system.lever[tan], system.lever[tan]])
        matrix[t, : a + 2 * m] = lever * matrix[z, : a + 2 * m] + holder.pivot_height_mm * matrix[x, : a + 2 * m]
        # The load, which acts through the pivot, leans on the contact that rotation has carried sideways.
        matrix[t, t] += holder.normal_load_N * holder.pivot_height_mm
        matrix[t] *= holder.rotational_compliance_rad_per_N_mm
        matrix[t, t] -= 1.0
        matrix[z, z] -= holder.normal_stiffness_N_per_mm
        rhs[z] = holder.load_N(0.0, system.pressed_height)
        held = self._held_place(stop)
        if held is None:
            matrix[x] *= self.series_compliance
        else:
            # The contact moves with the holder's translation and with its rotation about the pivot.
            matrix[x] *= holder.tangential_compliance_mm_per_N
            matrix[x, x] -= 1.0
            matrix[x, t] += holder.pivot_height_mm
            rhs[x] = -held
        if system.prescribed_height is not None:
            matrix[z] = 0.0
            matrix[z, z], rhs[z] = 1.0, system.prescribed_height
        if holder.tangential_compliance_mm_per_N == 0.0 and holder.play_mm == 0.0:
            rhs[x] = holder.pivot_height_mm * system.old_tilt - system.old_holder_x

    def _stick_or_slip_rows(
        self,
        matrix: Array,
        rhs: Array,
        slip_rows: Array,
        offset: Array,
        state: _Iterate,
        on: IntArray,
        tan: IntArray,
        stick: BoolArray,
        direction: Array,
    ) -> None:
        """Tangential equations of nodes near stick: zero slip, or the linearised projection onto the friction cone."""
        a, m = len(on), len(tan)
        mu = self.system.friction
        augmentation = 1.0 / (self._tangential_compliance(state.normal)[tan] + self.rig)
        column_of = np.full(self.count, -1)
        column_of[on] = np.arange(a)
        sticking = stick[tan]
        trial = state.tangential[tan] - augmentation[:, None] * state.slip[tan]
        size = np.maximum(np.linalg.norm(trial, axis=1), 1e-300)
        weight = np.minimum(mu * np.maximum(state.normal[tan], 0.0) / size, 1.0)
        d = direction[tan]
        index = np.arange(m)
        for c in range(2):
            rows = a + c * m + index
            matrix[rows] = slip_rows[c * m + index]
            rhs[rows] = -offset[c * m + index]
        slipping = np.flatnonzero(~sticking)
        if not len(slipping):
            return
        augmentation = augmentation[slipping]
        local = np.zeros((2, len(slipping), matrix.shape[1]))
        right = np.zeros((2, len(slipping)))
        # In absolute unknowns: q - mu p d - weight (1 - d d^T)(q - augmentation s) = 0, times the slip per traction.
        for c in range(2):
            rows = np.arange(len(slipping))
            local[c, rows, a + c * m + slipping] += 1.0
            local[c, rows, column_of[tan[slipping]]] -= mu * d[slipping, c]
            for e in range(2):
                projector = (1.0 if c == e else 0.0) - d[slipping, c] * d[slipping, e]
                factor = weight[slipping] * projector
                local[c, rows, a + e * m + slipping] -= factor
                local[c] += (factor * augmentation)[:, None] * slip_rows[e * m + slipping]
                right[c] -= factor * augmentation * offset[e * m + slipping]
        for c in range(2):
            matrix[a + c * m + slipping] = local[c] / augmentation[:, None]
            rhs[a + c * m + slipping] = right[c] / augmentation

    def _scaled_solve(self, matrix: Array, rhs: Array, tractions: int) -> Array | None:
        length = self.pressure * self.collective
        column = np.full(len(rhs), length)
        column[:tractions] = self.pressure
        row = np.full(len(rhs), 1.0 / length)
        # Tilts are measured by what they move at the pivot's height or at the contact's edge, whichever is more.
        reach = max(self.system.holder.pivot_height_mm, float(self.areas.sum()) ** 0.5)
        column[-1], row[-1] = length / reach, reach / length
        row[-3] = 1.0 / (self.system.holder.normal_load_N if self.system.prescribed_height is None else length)
        matrix *= row[:, None]
        matrix *= column
        _, _, solution, info = lapack.dgesv(matrix, row * rhs, overwrite_a=1)
        if info != 0 or not np.all(np.isfinite(solution)):
            return None
        return np.asarray(solution * column)

    def _outcome(
        self, state: _Iterate, active: BoolArray, stick: BoolArray, direction: Array, iterations: int
    ) -> NewtonOutcome:
        # Round-off may leave nodes on the verge of opening with a vanishing negative pressure.
        normal = np.where(active, np.maximum(state.normal, 0.0), 0.0)
        tangential = np.where(normal[:, None] > 0.0, state.tangential, 0.0)
        traction = self._world(normal, tangential)
        slip_size = np.linalg.norm(state.slip, axis=1)
        sliding = (normal > 0.0) & ~stick & (slip_size > 0.0)
        energy = np.where(sliding, np.maximum(-np.einsum("ij,ij->i", tangential, state.slip), 0.0), 0.0)
        factor = self.system.wear_work_per_load_and_slip
        wear_work = energy if factor == self.system.friction else np.where(sliding, factor * normal * slip_size, 0.0)
        sliding_under_pressure = sliding.copy()
        sliding &= self.system.friction > 0.0
        cosine = np.einsum("ij,ij->i", direction, -state.slip)[sliding] / slip_size[sliding]
        sine = np.abs(direction[sliding, 0] * state.slip[sliding, 1] - direction[sliding, 1] * state.slip[sliding, 0])
        angle = np.arctan2(sine / slip_size[sliding], cosine)
        scale = max(state.elastic, 1e-300)
        layer = self.system.compliance.layer
        return NewtonOutcome(
            converged=True,
            message=f"converged in {iterations} iterations",
            iterations=iterations,
            traction=traction,
            holder_x=state.holder_x,
            height=state.height,
            tilt=state.tilt,
            friction_energy=energy,
            wear_work=wear_work,
            slip_length=np.where(sliding_under_pressure, slip_size, 0.0),
            sticking=int((stick & (normal > 0.0)).sum()),
            force_error=self._unbalanced(state, traction),
            penetration=float(max(0.0, float((layer * normal - state.gap).max())) / scale),
            complementarity=float(np.abs(state.gap[normal > 0.0]).max() / scale),
            slip_direction_error=float(angle.max()) if len(angle) else 0.0,
            elastic_slip=float(layer * np.linalg.norm(tangential, axis=1).max() / scale),
        )

    def _unbalanced(self, state: _Iterate, traction: Array) -> float:
        """Largest unbalanced force on the holder over the normal force."""
        system, holder = self.system, self.system.holder
        force = self.areas @ traction
        expected = holder.load_N(state.height, system.pressed_height) if system.prescribed_height is None else force[2]
        errors = [abs(force[2] - expected)]
        held = self._held_place(self._stop(state))
        if held is None:
            errors.append(abs(force[0]))
        elif holder.tangential_compliance_mm_per_N > 0.0:
            translation = state.holder_x - holder.pivot_height_mm * state.tilt - held
            errors.append(abs(force[0] - translation / holder.tangential_compliance_mm_per_N))
        if holder.rotational_compliance_rad_per_N_mm > 0.0 and holder.pivot_height_mm > 0.0:
            moment = holder.pivot_height_mm * force[0] + (self.areas * system.lever) @ traction[:, 2]
            moment += holder.pivot_height_mm * holder.normal_load_N * state.tilt
            resisted = state.tilt / holder.rotational_compliance_rad_per_N_mm
            errors.append(abs(moment - resisted) / holder.pivot_height_mm)
        return float(max(errors) / max(abs(expected), 1e-300))

    def _failure(self, state: _Iterate, iterations: int, message: str) -> NewtonOutcome:
        return NewtonOutcome(
            converged=False,
            message=message,
            iterations=iterations,
            traction=self._world(state.normal, state.tangential),
            holder_x=state.holder_x,
            height=state.height,
            tilt=state.tilt,
            friction_energy=np.zeros(self.count),
            wear_work=np.zeros(self.count),
            slip_length=np.zeros(self.count),
            sticking=0,
            force_error=np.inf,
            penetration=np.inf,
            complementarity=np.inf,
            slip_direction_error=np.inf,
            elastic_slip=np.inf,
        )
