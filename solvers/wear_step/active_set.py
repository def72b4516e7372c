"""The contact conditions of all positions of a cycle on given normals, and the active set that fits them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from solvers.compiled import compiled
from solvers.contact import ContactProblem
from solvers.contact_layer import LayersAtNodes, layers_at_nodes, open_share
from solvers.errors import NotConvergedError
from solvers.friction_law import Friction
from solvers.wear_step.similar_equations import SimilarEquations
from solvers.wear_step.surfaces import Cycle, Depths, Facing

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]

# Layers stiffen with the pressure: linearised where it is high, they ask for less than nothing where it should be low.
_LARGEST_FALL = 0.2


@dataclass(frozen=True)
class Improved:
    """What a step of Newton's method comes to.

    pressure: (N,).  height: (positions,).  active: (N,) which nodes are in contact now.  fits: whether they were those
    assumed.  linear: whether the equations are, so that no further step would change pressures that fit.
    """

    pressure: Array
    height: Array
    active: BoolArray
    fits: bool
    linear: bool


@dataclass(frozen=True)
class CycleEquations:
    """Conditions on N pressures of all positions and their holder heights.

    base: (N,) gap along the normals by what does not depend on the pressures.  opening: (N, N) sparse, gap along z
    opened by wear work per area, of which layers fill a part.  open_share: the rest.  slip: (N,) mm.  wearing: (N,)
    factor on the wear coefficients.  cycles: (N,) for which each unknown wears.  first: (positions + 1,) where
    positions begin.
    pressed_z: height to which the loading spring refers, mm.  similar: what is known of such equations so far.
    """

    problem: ContactProblem
    facing: tuple[Facing, ...]
    first: IntArray
    upward: Array
    base: Array
    opening: csr_matrix
    open_share: float
    slip: Array
    wearing: Array
    cycles: Array
    layers: LayersAtNodes | None
    pressed_z: float
    similar: SimilarEquations

    @classmethod
    def of(
        cls,
        problem: ContactProblem,
        cycle: Cycle,
        facing: tuple[Facing, ...],
        gaps: Array,
        opening: csr_matrix,
        slip: Array,
        wearing: Array,
        cycles: Array,
        worn: Depths,
    ) -> CycleEquations:
        """Those of a stage on gaps (N,) before it, with normals and layers as on surfaces `worn`."""
        orbits = cycle.orbits
        upward = np.concatenate([face.upward for face in facing])
        layers = None
        if problem.layers:
            # In sliding layers are sheared steadily: only their closure matters.
            none = np.zeros((orbits.count, 3))
            layers = layers_at_nodes(problem.layers, orbits.opening(*worn), none, none)
        return cls(
            problem=problem,
            facing=facing,
            first=orbits.start,
            upward=upward,
            base=upward * gaps + np.concatenate([face.by_stuck for face in facing]),
            opening=opening,
            open_share=open_share(problem.layers),
            slip=slip,
            wearing=wearing,
            cycles=cycles,
            layers=layers,
            pressed_z=cycle.positions[0].state.pressed_z,
            similar=cycle.similar,
        )

    @property
    def _wear_work(self) -> Friction:
        """Wear work per slip, as a law of the pressure."""
        return self.problem.wear.work_per_slip(self.problem.law)

    def works(self, pressure: Array) -> tuple[Array, Array]:
        """Friction work and wear work (N,) of one cycle per area under pressures (N,)."""
        friction = self.problem.law.limit(pressure)
        return friction * self.slip, self._wear_work.limit(pressure) * self.slip * self.wearing

    def improved(self, about: Array, active: BoolArray) -> Improved:
        """One step of Newton's method from pressures (N,) with these nodes (N,) in contact.

        Raises:
            NotConvergedError: the equations do not determine the pressures.
        """
        new, height, gap, linear = self._newton_step(np.where(active, np.maximum(about, 0.0), 0.0), active)
        fits = bool(np.where(active, new >= 0.0, gap >= 0.0).all())
        pressure = new if linear else np.maximum(new, _LARGEST_FALL * about)
        return Improved(pressure, height, np.where(active, new > 0.0, gap < 0.0), fits, linear)

    def _newton_step(self, about: Array, active: BoolArray) -> tuple[Array, Array, Array, bool]:
        """One step of Newton's method from pressures (N,): new ones, heights (positions,), all gaps (N,), and whether
        no further step is needed on this active set.
        """
        holder, count = self.problem.holder, len(self.facing)
        on = np.flatnonzero(active)
        size = len(on)
        closure, softness = self._closure(about)
        slope, constant = self.problem.law.tangent(about)
        work_slope, work_constant = self._wear_work.tangent(about)
        constant, work_constant = np.where(active, constant, 0.0), np.where(active, work_constant, 0.0)
        opened = self.open_share * self.upward
        known = self.base + closure - softness * about
        if work_constant.any():
            known += opened * (self.opening @ (work_constant * self.slip * self.wearing * self.cycles))
        if constant.any():
            for face, own in zip(self.facing, self._parts(), strict=True):
                known[own] += face.by_friction @ constant[own][face.on]
        matrix, rhs = np.zeros((size + count, size + count), order="F"), np.zeros(size + count)
        worn = work_slope * self.slip * self.wearing * self.cycles
        _fill(matrix.T, self.opening.indptr, self.opening.indices, self.opening.data, on, opened, worn)
        matrix[np.arange(size), np.arange(size)] += softness[on]
        rhs[:size] = -known[on]
        begin = np.searchsorted(on, self.first)
        for k, (face, own) in enumerate(zip(self.facing, self._parts(), strict=True)):
            mine = slice(begin[k], begin[k + 1])
            _add_elastic(matrix.T[mine, mine], face.on, face.by_pressure, face.by_friction, slope[own])
            matrix[mine, size + k] = face.upward[face.on]
            if holder.approach_mm is not None:
                matrix[size + k, size + k], rhs[size + k] = 1.0, -holder.approach_mm
                continue
            matrix[size + k, mine] = (face.lift[0] + slope[own] * face.lift[1])[face.on]
            matrix[size + k, size + k] = -holder.normal_stiffness_N_per_mm
            rhs[size + k] = holder.load_N(0.0, self.pressed_z) - face.stuck_lift - face.lift[1] @ constant[own]
        unknowns = np.concatenate([on, len(active) + np.arange(count)])
        solution = _scaled_solution(matrix, rhs, unknowns, size, self.similar)
        new = np.zeros(len(active))
        new[on], height = solution[:size], solution[size:]
        gap = known + softness * new + self.upward * np.repeat(height, np.diff(self.first))
        gap += opened * (self.opening @ (worn * new))
        for face, own in zip(self.facing, self._parts(), strict=True):
            _add_moved(gap[own], face.on, face.by_pressure, face.by_friction, slope[own], new[own])
        linear = self.layers is None and not constant.any() and not work_constant.any()
        return new, height, gap, linear

    def _parts(self) -> list[slice]:
        """Where each position's unknowns stand."""
        return [slice(a, b) for a, b in pairwise(self.first)]

    def _closure(self, pressure: Array) -> tuple[Array, Array]:
        """Closure (N,) of what lies between the surfaces, and its derivative by the pressure."""
        penalty = np.full(len(pressure), self.problem.layer_mm_per_MPa)
        if self.layers is None:
            return penalty * pressure, penalty
        closure, softness = self.layers.closure(pressure)
        return closure + penalty * pressure, softness + penalty


def _scaled_solution(matrix: Array, rhs: Array, unknowns: IntArray, pressures: int, similar: SimilarEquations) -> Array:
    """Solution of equations whose first rows are gaps of nodes and last ones loads, scaled to be of order one."""
    row, column = _scaled(matrix.T, pressures)
    solution = similar.solution(unknowns, matrix, row * rhs, row, column)
    if solution is None or not np.all(np.isfinite(solution)):
        raise NotConvergedError("the pressures of a cycle on the surface that they wear are not determined")
    return np.asarray(solution * column)


@compiled
def _add_elastic(transposed: Array, on: IntArray, by_pressure: Array, by_friction: Array, slope: Array) -> None:
    """Add what unit pressure does among unknowns `on` with the friction that follows it, `slope` (u,) times as large,
    to a transposed matrix of these.
    """
    for j in range(len(on)):
        for i in range(len(on)):
            transposed[j, i] += by_pressure[on[i], j] + by_friction[on[i], j] * slope[on[j]]


@compiled
def _add_moved(gap: Array, on: IntArray, by_pressure: Array, by_friction: Array, slope: Array, pressure: Array) -> None:
    """Add to gaps (u,) what pressures on unknowns `on` do with that friction."""
    for i in range(len(gap)):
        moved = 0.0
        for j in range(len(on)):
            moved += (by_pressure[i, j] + by_friction[i, j] * slope[on[j]]) * pressure[on[j]]
        gap[i] += moved


@compiled
def _scaled(transposed: Array, pressures: int) -> tuple[Array, Array]:
    """Scale a matrix, given as its transpose, and return the factors of its rows and its columns.

    Those of its first rows and columns, as many as there are pressures, become of order one, then each row.
    """
    size = len(transposed)
    by_pressures, by_others = np.full(size, 1e-300), np.full(size, 1e-300)
    for j in range(size):
        largest = by_pressures if j < pressures else by_others
        for i in range(size):
            largest[i] = max(largest[i], abs(transposed[j, i]))
    column = np.ones(size)
    largest_by_pressure = 1e-300
    for i in range(pressures):
        largest_by_pressure = max(largest_by_pressure, by_pressures[i])
    column[:pressures] = 1.0 / largest_by_pressure
    row = np.empty(size)
    for i in range(size):
        row[i] = 1.0 / max(by_pressures[i] * column[0], by_others[i])
    for j in range(size):
        factor = column[j]
        for i in range(size):
            transposed[j, i] = transposed[j, i] * factor * row[i]
    return row, column


@compiled
def _fill(
    transposed: Array, first: IntArray, columns: IntArray, data: Array, on: IntArray, rows: Array, factors: Array
) -> None:
    """Write a sparse matrix' part between unknowns `on`, its rows and columns times factors, into a dense transpose."""
    place = np.full(len(rows), -1)
    for i in range(len(on)):
        place[on[i]] = i
    for i in range(len(on)):
        row = on[i]
        for entry in range(first[row], first[row + 1]):
            j = place[columns[entry]]
            if j >= 0:
                transposed[j, i] += rows[row] * data[entry] * factors[columns[entry]]
