"""Columns of families around one explanation: what each may change of the observables, to first order."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.families import FAMILIES, PROFILE_FAMILIES
from wirewear.diagnosis.infer.inference import Problem
from wirewear.diagnosis.infer.shapes import Branches, Family, Shape
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.setup import Array, Setup
from wirewear.diagnosis.observe.layout import Layout
from wirewear.diagnosis.observe.profiles import ProfileDepths
from wirewear.effects import Age, Ageing, Chain, Seam

_KNOWN = constants("infer.families")

#: Shares of the plateau force or of the amplitude by which a distortion is tried; none is more likely than another.
SIZES = _KNOWN.numbers("sizes")

#: Step of the derivatives, as such a share.
_STEP = _KNOWN.number("step")

#: What changes over the cycles does so over this difference of their logarithm, as Matérn's process of order 1/2.
REACH, KNOTS = _KNOWN.number("reach"), _KNOWN.count("knots")

#: Share of a developing distortion's variance that stays the same throughout.
LASTING = _KNOWN.number("lasting")


@dataclass(frozen=True, eq=False)
class FreeInTime:
    """One column of a chain that is changed over the cycles; it stands in a setup beside its effects.

    Attributes:
        column: of the chain.
        knots: logarithms (k,) of cycles.
        values: (k,) changes at these, linear between them.
        scale: what a change of one adds; 0 multiplies instead.
    """

    column: str
    knots: Array
    values: Array
    scale: float
    name: str = "free in time"
    ages: Ageing = Ageing.BY_CYCLES

    @property
    def seam(self) -> Seam | None:
        """None: it changes the chain itself."""
        return None

    def changed(self, described: object, _age: Age) -> object:
        """Nothing of a seam's description."""
        return described

    def foreseen(self, chain: Chain) -> Chain:
        """The chain with the column changed."""
        share = np.interp(np.log(np.maximum(chain.cycles, 1.0)), self.knots, self.values)
        was = getattr(chain, self.column)
        return replace(chain, **{self.column: was * (1.0 + share) if self.scale == 0.0 else was + self.scale * share})


@dataclass(frozen=True, eq=False)
class Columns:
    """A family around one explanation.

    Attributes:
        family: whose they are.
        weight: belief in them before looking, among all of one family.
        observed: (n, k) changes of the observables by a standard deviation of each of its k unknowns, of unit size.
        knots: (j,) logarithms of the cycles between which what changes in time goes straight; empty for shapes.
        of_unknowns: (j, k) its values there by its unknowns.
    """

    family: Family
    weight: float
    observed: Array
    knots: Array
    of_unknowns: Array


def families_of(layout: Layout) -> tuple[Family, ...]:
    """Those that a layout can show: of loops, of what changes over several logged cycles, of profiles."""
    loops = any(not part.observable.of_scars for part in layout)
    several = np.unique(layout.cycle).size > 1
    found = tuple(one for one in FAMILIES if loops and (several or not one.column))
    return (*found, *PROFILE_FAMILIES) if layout.of_kind(ProfileDepths).any() else found


def columns_of(problem: Problem, setup: Setup) -> tuple[tuple[Columns, ...], ...]:
    """All families around a setup; of each, the columns that it may have, one set instead of another."""
    layout, states = problem.layout, problem.states
    course = simulate(states, setup, layout.cycles)
    base = layout.observed(course)
    branches = Branches.of(course, setup.amplitude_um, setup.plateau_force_N, setup.motion)
    logged = np.log(np.unique(np.maximum(layout.cycle, 1)).astype(float))
    knots = np.linspace(logged[0], logged[-1], min(KNOTS, logged.size))
    found = []
    for family in families_of(layout):
        if family.shapes:
            each = (family.shapes, *family.instead)
            sets = [
                np.nan_to_num(np.column_stack([*_of_shapes(family, one, problem, branches, base, logged)]))
                for one in each
            ]
            nowhere = np.zeros(0), np.zeros((0, 0))
            found.append(tuple(Columns(family, 1.0 / len(sets), one, *nowhere) for one in sets))
        else:
            found.append(_courses(family, problem, setup, base, knots))
    return tuple(found)


def _courses(family: Family, problem: Problem, setup: Setup, base: Array, knots: Array) -> tuple[Columns, ...]:
    """Columns of what changes in time: freely, or, as likely as that, towards a final value as creep and warmth do."""
    free: Array = np.asarray(np.linalg.cholesky(_kernel(knots, 0.0)), dtype=np.float64)
    observed = np.nan_to_num(np.column_stack(list(_in_time(family, problem, setup, base, knots, free))))
    found = [Columns(family, 0.5, observed, knots, free)]
    # Linear in the values at knots, as the free courses are.
    by_values = observed @ np.linalg.inv(free)
    for late in knots[1:]:
        settling = (1.0 - np.exp(-np.exp(knots - late)))[:, None]
        found.append(Columns(family, 0.5 / (knots.size - 1), by_values @ settling, knots, settling))
    return tuple(found)


def _of_shapes(
    family: Family, shapes: Sequence[Shape], problem: Problem, branches: Branches, base: Array, logged: Array
) -> Iterator[Array]:
    row = np.searchsorted(logged, np.log(np.maximum(problem.layout.cycle, 1)) - 1e-9)
    step = family.step or _STEP
    for shape in shapes:
        change = (problem.layout.observed(shape(branches, step)) - base) / step
        if not family.develops:
            yield change
            continue
        for weights in np.linalg.cholesky(_kernel(logged, LASTING)).T:
            yield change * weights[row]


def _in_time(
    family: Family, problem: Problem, setup: Setup, base: Array, knots: Array, values: Array
) -> Iterator[Array]:
    force = setup.plateau_force_N
    scale = {"": 0.0, "force": force, "compliance": setup.amplitude_um / force}[family.scale]
    for weights in values.T:
        moved = FreeInTime(family.column, knots, _STEP * weights, scale)
        changed = replace(setup, effects=(*setup.effects, moved))
        course = simulate(problem.states, changed, problem.layout.cycles)
        yield (problem.layout.observed(course) - base) / _STEP


def _kernel(time: Array, lasting: float) -> Array:
    """Covariance (k, k) of a size over logarithms of cycles (k,)."""
    apart = np.abs(time[:, None] - time)
    kernel: Array = lasting + (1.0 - lasting) * np.exp(-apart / REACH) + 1e-9 * np.eye(time.size)
    return kernel
