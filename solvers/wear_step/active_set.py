"""The contact conditions of all positions of a cycle on given normals, and the active set (nodes in contact) that fits
them.

Unknowns are N pressures, those of all positions one after another, and the height of the holder at each position. A gap
is along z, positive where the bodies are apart.
"""

from dataclasses import dataclass
from functools import cached_property
from math import nan
from typing import NamedTuple

import numpy as np

from geometry.arrays import Array, BoolArray, IntArray
from solvers.contact import ContactProblem
from solvers.elasticity.nodal_transfer import NodalTransfer
from solvers.errors import NotConvergedError
from solvers.jit_cache import compiled, inlined
from solvers.laws.friction_law import Friction
from solvers.laws.layers import LayersAtNodes, layers_at_nodes
from solvers.laws.yielding import YieldAtNodes
from solvers.wear_step.coupled import Coupled
from solvers.wear_step.orbits import Opening, scaled_rows
from solvers.wear_step.surfaces import Cycle, Depths, Facing, moved_along

# Layers stiffen with the pressure: linearised where it is high, they ask for less than nothing where it should be low.
_LARGEST_FALL = 0.2


@dataclass(frozen=True)
class Improved:
    """Result of one step of Newton's method."""

    pressure: Array  #: (N,) MPa.
    height: Array  #: (positions,) of the holder, mm.
    active: BoolArray  #: (N,) which unknowns to take as in contact next.
    fits: bool  #: True if they are those assumed: no pressure pulls, no open gap overlaps.
    linear: bool  #: True if the equations are linear, so that no further step would change pressures that fit.


@dataclass(frozen=True)
class CycleEquations:
    """Contact conditions for the N pressures (MPa) at all positions of a cycle and the holder's height (mm) at each."""

    problem: ContactProblem
    cycle: Cycle
    facing: Facing  #: Normals and loads on the surfaces assumed.
    gaps: Array  #: (N,) mm along z before the stage, with the holder at height 0.
    opening: Opening  #: From wear work to the gap that it opens along z, without what debris fills of it.
    slip: Array  #: (N,) mm, mean of that before and after the position.
    cycles: Array  #: (N,) number of cycles for which each unknown wears.
    worn: Depths  #: Worn depths in mm whose debris is still there, for layers.
    friction: Friction  #: The law at the unknowns.
    yielding: YieldAtNodes | None = None  #: Pressure limits at the unknowns; None if nothing yields.

    @cached_property
    def _layers(self) -> LayersAtNodes | None:
        if not self.problem.layers:
            return None
        # In sliding layers are sheared steadily: only their closure matters.
        none = np.zeros((len(self.gaps), 3))
        return layers_at_nodes(self.problem.layers, self.cycle.orbits.opening(*self.worn), none, none)

    def works(self, pressure: Array) -> tuple[Array, Array]:
        """Friction work and wear work (N,) of one cycle per area in mJ/mm² under pressures (N,) in MPa."""
        energy, worn = self.friction.limit(pressure) * self.slip, self.problem.wear.law.work_per_slip(self.friction)
        if worn is self.friction and isinstance(self.cycle.wearing, float):
            return energy, energy if self.cycle.wearing == 1.0 else energy * self.cycle.wearing
        return energy, worn.limit(pressure) * self.slip * self.cycle.wearing

    def improved(self, about: Array, active: BoolArray) -> Improved:
        """One step of Newton's method from pressures `about` (N,) in MPa, with the unknowns marked in `active` (N,) in
        contact. Raises NotConvergedError if the equations do not determine the pressures.
        """
        new, height, gap, linear = self._newton_step(np.where(active, np.maximum(about, 0.0), 0.0), active)
        fits = bool(np.where(active, new >= 0.0, gap >= 0.0).all())
        pressure = new if linear else np.maximum(new, _LARGEST_FALL * about)
        return Improved(pressure, height, np.where(active, new > 0.0, gap < 0.0), fits, linear)

    def _newton_step(self, about: Array, active: BoolArray) -> tuple[Array, Array, Array, bool]:
        """One step of Newton's method from pressures (N,): new ones, heights (positions,), all gaps (N,), and whether
        no further step is needed on this active set.
        """
        cycle, facing, holder, on = self.cycle, self.facing, self.problem.holder, np.flatnonzero(active)
        closure, softness = self._closure(about)
        slope, constant = self.friction.tangent(about)
        work_slope, work_constant = self.problem.wear.law.work_per_slip(self.friction).tangent(about)
        constant, work_constant = np.where(active, constant, 0.0), np.where(active, work_constant, 0.0)
        opened, wearing = facing.upward, self.slip * cycle.wearing * self.cycles
        known = facing.upward * self.gaps + facing.by_stuck + closure - softness * about
        if work_constant.any():
            known += opened * self.opening.by(work_constant * wearing)
        states = [position.state for position in cycle.positions]
        loads = [holder.under(state.load_share).load_N(0.0, state.pressed_z) for state in states]
        terms = _Terms(
            *(cycle.orbits.start, cycle.nodes.rows, on, cycle.orbits.position[on]),
            *(cycle.influences.store, cycle.influences.at),
            *(NodalTransfer.of(self.opening.faced), NodalTransfer.of(self.opening.worked)),
            *(opened, work_slope * wearing),
            *(softness, slope, constant, known, np.array(loads if holder.approach_mm is None else [nan] * len(loads))),
            *(holder.approach_mm or 0.0, holder.normal_stiffness_N_per_mm),
        )
        moved, rhs = _sides(terms, facing)
        unknowns = np.concatenate([on, len(active) + np.arange(len(cycle.positions))])
        alone, carried = _alone(terms, facing, moved)
        if not carried.all():
            raise NotConvergedError("nothing is left in contact that carries the load at a position of the cycle")
        solution = cycle.similar.solution(
            *(unknowns, rhs, np.concatenate([np.ones(len(on)), 1.0 / carried]), float(np.median(alone))),
            lambda some: _product(terms, facing, moved, some),
            lambda: self._coupled(terms, moved),
        )
        if solution is None or not np.all(np.isfinite(solution)):
            raise NotConvergedError("the pressures of a cycle on the surface that they wear are not determined")
        new, gap = np.zeros(len(active)), _gaps(terms, facing, moved, solution)
        new[on] = solution[: len(on)]
        straight = not constant.any() and not work_constant.any() and self._stays(about, new)
        linear = self._layers is None and straight
        return new, solution[len(on) :], gap, linear

    def _coupled(self, terms: "_Terms", moved: Array) -> Coupled:
        """The matrix of `_product`."""
        on, blocks, begin = terms.on, [], 0
        together = _blocks(terms, self.facing, moved)
        for size in np.bincount(terms.position, minlength=len(terms.start) - 1) + 1:
            blocks.append(together[begin : begin + size**2].reshape(size, size).T)
            begin += size**2
        opened, worked = scaled_rows(self.opening.faced[on], terms.opened[on]), self.opening.worked[on]
        return Coupled(blocks, opened, scaled_rows(worked, terms.worn[on]))

    def _stays(self, about: Array, new: Array) -> bool:
        """Whether what yields is the same under both pressures (N,)."""
        limit = np.inf if self.yielding is None else self.yielding.limit
        return bool(((about > limit) == (new > limit)).all())

    def _closure(self, pressure: Array) -> tuple[Array, Array]:
        """Closure (N,) of what lies between the surfaces, and its derivative by the pressure."""
        penalty = np.full(len(pressure), self.problem.layer_mm_per_MPa)
        parts = [layers.closure(pressure) for layers in (self._layers, self.yielding) if layers is not None]
        if not parts:
            return penalty * pressure, penalty
        closure, softness = (sum(part) for part in zip(*parts, strict=True))
        return closure + penalty * pressure, softness + penalty


class _Terms(NamedTuple):
    """What the equations of N unknowns are made of: arrays over the unknowns, and plain numbers.

    start: (positions + 1,) where positions begin.  rows: see `CycleNodes`.  on: (a,) unknowns in contact, at which
    position.  store, at: see `Influences`.  faced, worked: of `Opening`, whose rows count `opened`
    times, its columns `worn` times.  slope, constant: friction's tangent.  known: gap without elastic displacement and
    wear, which gets what constant friction does.  load_N: (positions,) at height 0, NaN under a held approach.
    """

    start: IntArray
    rows: IntArray
    on: IntArray
    position: IntArray
    store: Array
    at: IntArray
    faced: NodalTransfer
    worked: NodalTransfer
    opened: Array
    worn: Array
    softness: Array
    slope: Array
    constant: Array
    known: Array
    load_N: Array
    approach_mm: float
    spring_N_per_mm: float


@compiled
def _sides(terms: _Terms, facing: Facing) -> tuple[Array, Array]:
    """What makes up both sides of the equations: normal displacement at all unknowns of a position by unit pressure on
    each in contact, with the friction that follows it, one after another; and the right-hand side.

    What constant friction does is added to the gaps.
    """
    on, start, size, count, entry = terms.on, terms.start, len(terms.on), len(terms.start) - 1, 0
    for k in terms.position:
        entry += start[k + 1] - start[k]
    moved, rhs, entry = np.empty(entry), np.zeros(size + count), 0
    held = np.isnan(terms.load_N[0])
    for k in range(count):
        rhs[size + k] = -terms.approach_mm if held else terms.load_N[k] - facing.stuck_lift[k]
    for a in range(size):
        j, k = on[a], terms.position[a]
        slope, constant = terms.slope[j], terms.constant[j]
        if not held:
            rhs[size + k] -= facing.lift[1, j] * constant
        normal, friction = facing.normals[terms.rows[j]], facing.frictions[terms.rows[j]]
        x, y, z = normal[0] + slope * friction[0], normal[1] + slope * friction[1], normal[2] + slope * friction[2]
        for i in range(start[k], start[k + 1]):
            block, along = terms.at[j] + 9 * (i - start[k]), facing.normals[terms.rows[i]]
            moved[entry] = moved_along(terms.store, block, along, x, y, z)
            if constant != 0.0:
                rubbed = moved_along(terms.store, block, along, friction[0], friction[1], friction[2])
                terms.known[i] += constant * rubbed
            entry += 1
    for a in range(size):
        rhs[a] = -terms.known[on[a]]
    return moved, rhs


@compiled
def _alone(terms: _Terms, facing: Facing, moved: Array) -> tuple[Array, Array]:
    """Gap in mm that each pressure (a,) in contact opens at its own node, per MPa; and for each position how large the
    equation of its load is beside those of gaps: by what pressures of a unit load open where that is most.
    """
    on, start, faced, worked = terms.on, terms.start, terms.faced, terms.worked
    alone, carried, entry, most = np.empty(len(on)), np.zeros(len(start) - 1), 0, 1e-300
    for a in range(len(on)):
        i, k = on[a], terms.position[a]
        alone[a] = moved[entry + i - start[k]] + terms.softness[i]
        for f in range(faced.first[i], faced.first[i + 1]):
            for w in range(worked.first[i], worked.first[i + 1]):
                if faced.columns[f] == worked.columns[w]:
                    alone[a] += terms.opened[i] * faced.weights[f] * worked.weights[w] * terms.worn[i]
        most = max(most, alone[a])
        carried[k] = max(carried[k], abs(facing.lift[0, i] + terms.slope[i] * facing.lift[1, i]))
        entry += start[k + 1] - start[k]
    if np.isnan(terms.load_N[0]):
        return alone, np.ones(len(carried))
    for k in range(len(carried)):
        carried[k] = max(carried[k] / most, terms.spring_N_per_mm)
    return alone, carried


@compiled
def _blocks(terms: _Terms, facing: Facing, moved: Array) -> Array:
    """The blocks of `Coupled`, transposed, one after another."""
    on, start, held, first = terms.on, terms.start, np.isnan(terms.load_N[0]), 0
    size = np.ones(len(start) - 1, np.int64)
    for k in terms.position:
        size[k] += 1
    blocks, at, entry = np.empty((size * size).sum()), 0, 0
    for k in range(len(size)):
        last = first + size[k] - 1
        for a in range(first, last):
            i = on[a]
            for b in range(first, last):
                blocks[at + b - first] = moved[entry + on[b] - start[k]]
            blocks[at + a - first] += terms.softness[i]
            blocks[at + last - first] = 0.0 if held else facing.lift[0, i] + terms.slope[i] * facing.lift[1, i]
            at, entry = at + size[k], entry + start[k + 1] - start[k]
        for a in range(first, last):
            blocks[at + a - first] = facing.upward[on[a]]
        blocks[at + last - first] = 1.0 if held else -terms.spring_N_per_mm
        at, first = at + size[k], last
    return blocks


@compiled
def _product(terms: _Terms, facing: Facing, moved: Array, solution: Array) -> Array:
    """The left-hand side under pressures in contact and heights.  moved: as `_sides` returns it."""
    on, start, size, held = terms.on, terms.start, len(terms.on), np.isnan(terms.load_N[0])
    work, left, entry = _work(terms, solution), np.empty(len(solution)), 0
    # Number of the pressures at all positions before each.
    first = np.zeros(len(start), np.int64)
    for k in terms.position:
        first[k + 1] += 1
    for k in range(1, len(start)):
        first[k] += first[k - 1]
    for k in range(len(start) - 1):
        height = solution[size + k]
        left[size + k] = height if held else -terms.spring_N_per_mm * height
        for a in range(first[k], first[k + 1]):
            i, pressure = on[a], solution[a]
            left[a] = facing.upward[i] * height + _opened(terms, i, work) + terms.softness[i] * pressure
            if not held:
                left[size + k] += (facing.lift[0, i] + terms.slope[i] * facing.lift[1, i]) * pressure
        for a in range(first[k], first[k + 1]):
            for b in range(first[k], first[k + 1]):
                left[b] += moved[entry + on[b] - start[k]] * solution[a]
            entry += start[k + 1] - start[k]
    return left


@compiled
def _gaps(terms: _Terms, facing: Facing, moved: Array, solution: Array) -> Array:
    """Gaps (N,) under a solution."""
    on, start, work = terms.on, terms.start, _work(terms, solution)
    gap, entry = np.empty(len(terms.known)), 0
    for k in range(len(start) - 1):
        for i in range(start[k], start[k + 1]):
            gap[i] = terms.known[i] + facing.upward[i] * solution[len(on) + k] + _opened(terms, i, work)
    for a in range(len(on)):
        k = terms.position[a]
        gap[on[a]] += terms.softness[on[a]] * solution[a]
        for i in range(start[k], start[k + 1]):
            gap[i] += moved[entry] * solution[a]
            entry += 1
    return gap


@inlined
def _work(terms: _Terms, solution: Array) -> Array:
    """Wear work per area on the nodes of both patches under a solution."""
    worked, work = terms.worked, np.zeros(terms.worked.size)
    for a in range(len(terms.on)):
        j = terms.on[a]
        for entry in range(worked.first[j], worked.first[j + 1]):
            work[worked.columns[entry]] += worked.weights[entry] * terms.worn[j] * solution[a]
    return work


@inlined
def _opened(terms: _Terms, i: int, work: Array) -> float:
    """By how much the work opens the gap at an unknown."""
    faced, worn = terms.faced, 0.0
    for entry in range(faced.first[i], faced.first[i + 1]):
        worn += faced.weights[entry] * work[faced.columns[entry]]
    return float(terms.opened[i] * worn)
