"""What an explanation leaves over beyond chance; explanations not recognised by what they are named for."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import e, expm1, hypot, log, log1p, sqrt

import numpy as np
from scipy.stats import chi2

from geometry.arrays import Array
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.covariance import SHARED, Covariance
from wirewear.diagnosis.infer.inference import Fit, Problem
from wirewear.diagnosis.infer.solver_differences import derivatives
from wirewear.diagnosis.infer.weighing import SEPARABLE, Weighed
from wirewear.diagnosis.observe.layout import Part

_OF_GATE = constants("infer.gate")

#: Standard deviation of the logarithm by which the variance of one observable's solver differences lies above or below
#: the learned one, from test to test.
SCALE = _OF_GATE.number("scale")

#: Places and weights of a normal deviate, for means over it.
_PLACES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(_OF_GATE.count("places"))

#: Below it a chance has no digits left.
_LEAST_P = 1e-300


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
    return weighed.given_outside(bare)


def log_surprise(p_value: float) -> float:
    """Log of the largest Bayes factor that a p-value gives something else being at work, 0 if none.

    −e p ln p is the least that it leaves of a hypothesis (Sellke, Bayarri and Berger, Am. Stat. 55 (2001) 62, eq. 2).
    """
    p = max(p_value, _LEAST_P)
    return -log(-e * p * log(p)) if p < 1.0 / e else 0.0


@dataclass(frozen=True)
class Remainder:
    """What an explanation leaves over: chi² per observable, and the least likely of all `blocks` of observables."""

    misfit: float
    block_p_value: float
    blocks: int

    @property
    def log_surprise(self) -> float:
        """That of the worst block, the least of several."""
        return log_surprise(-expm1(self.blocks * log1p(-min(self.block_p_value, 0.5))))


def remainder_of(problem: Problem, one: Fit) -> Remainder:
    """Judge the whitened residuals of a fit, as a whole and by observable."""
    residual = problem.mean - problem.predicted(one.setup)
    whitened = problem.whitening @ residual
    misfit = float(whitened @ whitened) / max(whitened.size - one.coordinates.size, 1)
    covariance = np.linalg.inv(problem.whitening.T @ problem.whitening)

    def p_value(part: Part) -> float:
        block, rest = covariance[part.rows, part.rows], residual[part.rows]
        return chance(float(rest @ np.linalg.solve(block, rest)), rest.size)

    return Remainder(misfit, min(map(p_value, problem.layout), default=1.0), len(problem.layout.parts))


def chance(squares: float, count: int, scale: float = SCALE) -> float:
    """Of a chi square of so many numbers or a larger one, the logarithm of their variance being known within `scale`.

    It is the mean over that of what it were with the variance known: a posterior predictive p-value.
    """
    scaled = squares * np.exp(-scale * _PLACES)
    return float(_WEIGHTS @ chi2.sf(scaled, count) / _WEIGHTS.sum())
