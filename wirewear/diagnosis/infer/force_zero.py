"""Where the zero of the force lies by the loops, beside what an explanation says of them."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, sqrt

from wirewear.diagnosis.infer.covariance import SHARED, Covariance
from wirewear.diagnosis.infer.inference import Fit, Problem
from wirewear.diagnosis.infer.solver_differences import derivatives
from wirewear.diagnosis.infer.weighing import SEPARABLE


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
