"""Rough layers, debris and running-in by laws that neither the library's effects nor the independent model follow.

Each makes a world of the independent model from one with the effect of the library: of the same size, by another law.
Laws of running-in keep the initial value, the final one and the scale of cycles.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import overload

import numpy as np
from numpy.typing import NDArray

from studies.blind.generators.cases import Case
from studies.blind.generators.independent.model import IndependentModel
from studies.blind.generators.independent.world import World
from wirewear.base.course import Course

Array = NDArray[np.float64]


Remaining = Callable[[Array], Array]


def hyperbolic(passed: Array) -> Array:
    """Slower the longer it lasts: second-order kinetics, as where what wears off is what is left to rub."""
    return 1.0 / (1.0 + passed)


def logarithmic(passed: Array) -> Array:
    """A straight line over the logarithm of the cycles, two decades long about the scale."""
    return np.clip(0.5 - 0.5 * np.log10(np.maximum(passed, 1e-9)), 0.0, 1.0)


def delayed(passed: Array) -> Array:
    """Nothing for a while, then all within an octave: a film that holds until it breaks."""
    return 1.0 / (1.0 + passed**3)


def in_two_steps(passed: Array) -> Array:
    """Half of it at a third of the scale, half at three scales: two films, one after the other."""
    return 0.5 / (1.0 + (3.0 * passed) ** 4) + 0.5 / (1.0 + (passed / 3.0) ** 4)


def fast_then_logarithmic(passed: Array) -> Array:
    """Most of it soon, the rest over two decades: what is stripped at once, and what debris covers slowly."""
    return 0.6 * np.exp(-3.0 * passed) + 0.4 * logarithmic(passed / 3.0)


def half_lasting(passed: Array) -> Array:
    """Half of it stays for good, the rest goes slower the longer it lasts."""
    return 0.5 + 0.5 * hyperbolic(passed)


def lasting(passed: Array) -> Array:
    """A third stays for good: waviness of long wavelength that wear does not reach."""
    return 1.0 / 3.0 + 2.0 / 3.0 * np.exp(-passed)


@dataclass(frozen=True)
class CourseByAnotherLaw(Course):
    """A course of which `remaining` says how much of the change is left after so many scales of cycles."""

    remaining: Remaining = hyperbolic

    @overload
    def at(self, cycles: float) -> float: ...

    @overload
    def at(self, cycles: Array) -> Array: ...

    def at(self, cycles: float | Array) -> float | Array:
        """The value after so many cycles, one or (n,)."""
        values = self.final + (self.initial - self.final) * self.remaining(np.asarray(cycles / self.cycles))
        return values if isinstance(cycles, np.ndarray) else float(values)


Law = Callable[[World], World]
RUNNING_IN: Mapping[str, Remaining] = {
    "hyperbolic": hyperbolic,
    "logarithmic": logarithmic,
    "delayed": delayed,
    "in two steps": in_two_steps,
    "fast then slow": fast_then_logarithmic,
}
WEARING_IN: Mapping[str, Remaining] = {
    "hyperbolic": hyperbolic,
    "logarithmic": logarithmic,
    "a third stays": lasting,
    "in two steps": in_two_steps,
    "a half stays": half_lasting,
}


def by(course: Course, remaining: Remaining) -> Course:
    """The course by another law."""
    return CourseByAnotherLaw(course.initial, course.final, course.cycles, remaining=remaining)


def friction_by(remaining: Remaining) -> Law:
    """Friction that runs in by another law."""
    return lambda world: replace(world, friction=replace(world.friction, course=by(world.friction.course, remaining)))


def wear_by(remaining: Remaining) -> Law:
    """Wear that runs in by another law."""
    return lambda world: replace(world, wear=replace(world.wear, factor=by(world.wear.factor, remaining)))


def roughness_by(remaining: Remaining) -> Law:
    """A rough layer that wears in by another law."""
    return lambda world: replace(world, layers=replace(world.layers, rough_mm=by(world.layers.rough_mm, remaining)))


def even_bed(world: World) -> World:
    """Debris that stays where it is made: as thick as a share of the depth, everywhere."""
    return replace(world, layers=replace(world.layers, gathering=0.0))


def gathered_bed(world: World) -> World:
    """Debris that gathers in the deepest part."""
    return replace(world, layers=replace(world.layers, gathering=3.0))


def full_bed(world: World) -> World:
    """A bed that is full at a thickness of 1 µm: what comes on top is ejected."""
    return replace(world, layers=replace(world.layers, full_mm=1e-3))


def full_even_bed(world: World) -> World:
    """Debris that stays where it is made, up to 4 µm."""
    return replace(world, layers=replace(world.layers, gathering=0.0, full_mm=4e-3))


def full_gathered_bed(world: World) -> World:
    """Debris that gathers in the deepest part, up to 4 µm."""
    return replace(world, layers=replace(world.layers, gathering=3.0, full_mm=4e-3))


#: Laws by effect, by their name in tables.
LAWS: Mapping[str, Mapping[str, Law]] = {
    "friction_evolution": {name: friction_by(law) for name, law in RUNNING_IN.items()},
    "wear_rate_evolution": {name: wear_by(law) for name, law in RUNNING_IN.items()},
    "roughness_compliance": {name: roughness_by(law) for name, law in WEARING_IN.items()},
    "third_body": {
        "even bed": even_bed,
        "gathered bed": gathered_bed,
        "full bed": full_bed,
        "even full bed": full_even_bed,
        "gathered full bed": full_gathered_bed,
    },
}


@dataclass(frozen=True)
class ModelOfOtherForm(IndependentModel):
    """The independent model, its one effect by another law of the list above."""

    form: tuple[str, str] = ("friction_evolution", "hyperbolic")

    def true_world(self, case: Case) -> World:
        """The world with the case's effect by this law."""
        effect, law = self.form
        return LAWS[effect][law](super().true_world(case))
