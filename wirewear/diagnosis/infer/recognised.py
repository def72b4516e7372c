"""Explanations that fit by what they are not named for, and gaps that are none: what is said of them instead."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import hypot, sqrt

import numpy as np

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.covariance import SHARED, Covariance
from wirewear.diagnosis.infer.inference import Fit, Problem
from wirewear.diagnosis.infer.solver_differences import derivatives
from wirewear.diagnosis.infer.weighing import SEPARABLE, Weighed
from wirewear.diagnosis.model.setup import Array

#: Chi squares per number of records without a gap, sorted.
LEFT = np.sort(constants("infer.without_gap").numbers("left"))


@dataclass(frozen=True)
class ForceZero:
    """Mean zero of all repeats, and how many of its expected deviations that is."""

    value_N: float
    deviations: float

    @property
    def stands_out(self) -> bool:
        """Whether chance would hardly have it so far off."""
        return abs(self.deviations) > SEPARABLE


def force_zero(problem: Problem, covariance: Covariance, one: Fit, repeats: int) -> ForceZero:
    """The zero's mean, given what an explanation leaves of the loops.

    It is a normal deviate beforehand, so that its mean afterwards is its variance times its column in Σ⁻¹ r.
    """
    expected = hypot(SHARED["force_offset"], covariance.scatter["force_offset"] / sqrt(repeats))
    column = derivatives(problem.states, one.setup, problem.layout, {"force_offset": expected})[:, 0]
    deviations = float((problem.whitening @ column) @ problem.whitened(one.setup))
    return ForceZero(deviations * expected * problem.setup.load_N, deviations)


def left_by(problem: Problem, fit: Fit) -> float:
    """Chi square per number that an explanation leaves, none among them."""
    whitened = problem.whitened(fit.setup)
    return float(whitened @ whitened) / max(whitened.size, 1)


def share_beyond(left: float) -> float:
    """Of records without a gap those that leave more than so much per number; linear between them, never 0 or 1."""
    level = np.arange(1, LEFT.size + 1) / (LEFT.size + 1.0)
    return float(1.0 - np.interp(left, LEFT, level))


def unrecognised(fits: Iterable[Fit], cycles: Array) -> dict[tuple[str, ...], tuple[str, ...]]:
    """Those effects of each fit that do not do, within these cycles, what tells them from others.

    Loops of one cycle or of none show no course: of them there are none.
    """
    if np.unique(cycles).size < 2:
        return {}
    first, last = float(cycles.min()), float(cycles.max())
    found = {
        one.names: tuple(
            candidate.name
            for candidate, coordinates, _ in one.parts()
            if not candidate.effect(coordinates).recognised_between(first, last)
        )
        for one in fits
    }
    return {names: members for names, members in found.items() if members}


def without(weighed: Weighed, failing: Mapping[tuple[str, ...], Sequence[str]]) -> Weighed:
    """Probabilities with those of explanations that are not recognised given to a cause of no library.

    What such an explanation fits by is there, but it is not what it is named for. `failing` are its effects that do not
    do what they are named for. One that shares its class with an effect that does keeps its probability: the class
    stays right.
    """
    bare = {
        names
        for names, members in failing.items()
        if any(all((other,) in failing for other in weighed.class_of(one) if other != one) for one in members)
    }
    moved = sum(weighed.probabilities.get(names, 0.0) for names in bare)
    kept = {names: 0.0 if names in bare else probability for names, probability in weighed.probabilities.items()}
    return replace(weighed, probabilities=kept, outside=weighed.outside + moved)
