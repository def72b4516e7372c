"""The gate before a name: what an explanation leaves over, as evidence for a cause outside the library."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import binom

from tests.diagnosis_cases import diagnosed, nominal, record
from wirewear.diagnosis.diagnose import none_is_likely
from wirewear.diagnosis.infer.gate import SCALE, Remainder, remainder_of
from wirewear.diagnosis.infer.inference import Fit, Problem
from wirewear.diagnosis.infer.weighing import Weighed, weigh


def remainder(p_value: float, blocks: int = 1) -> Remainder:
    return Remainder(0.5, "stick", p_value, 1.0, blocks)


def weighed(log_surprise: float) -> Weighed:
    nothing = Fit((), np.zeros(0), np.zeros((0, 0)), nominal(), 100.0, -50.0)
    return weigh(nothing, (), (), -1000.0, (), 1.0, log_surprise)


@cache
def explained() -> tuple[Problem, Fit]:
    """A record without a gap, and the explanation that nothing is the matter."""
    found = diagnosed(record()).search
    return found.problem, found.none


def left_over(noise: NDArray[np.float64]) -> Remainder:
    """What no effect at all leaves of a record that differs from its prediction by this noise only."""
    problem, nothing = explained()
    return remainder_of(replace(problem, mean=problem.predicted(nothing.setup) + noise), nothing)


def believed_noise(count: int) -> NDArray[np.float64]:
    """Draws (count, n) from the covariance that the diagnosis believes in."""
    problem, _ = explained()
    covariance = np.linalg.inv(problem.whitening.T @ problem.whitening)
    return np.random.default_rng(3).multivariate_normal(np.zeros(len(covariance)), covariance, count, method="cholesky")


def test_a_remainder_that_chance_explains_is_no_surprise() -> None:
    assert remainder(0.5).log_surprise == 0.0
    assert remainder(0.08, blocks=10).log_surprise == 0.0


@pytest.mark.parametrize("p_value", [0.2, 0.01, 1e-6])
def test_the_surprise_is_the_largest_bayes_factor_of_any_falling_density_of_p(p_value: float) -> None:
    """Sellke, Bayarri and Berger's class of alternatives ξ p^(ξ − 1), 0 < ξ ≤ 1, searched through."""
    shape = np.linspace(1e-4, 1.0, 200_001)
    largest = np.max(np.log(shape) + (shape - 1.0) * np.log(p_value))
    assert remainder(p_value).log_surprise == pytest.approx(largest, abs=1e-6)


def test_of_many_blocks_the_least_likely_one_surprises_less() -> None:
    assert remainder(0.001, blocks=10).log_surprise == pytest.approx(remainder(0.00996).log_surprise, abs=2e-3)
    assert remainder(0.0).log_surprise > 600.0


def test_the_less_likely_the_remainder_the_larger_the_surprise() -> None:
    surprises = [remainder(p, blocks=8).log_surprise for p in (1e-2, 1e-4, 1e-8, 1e-20)]
    assert surprises == sorted(surprises)


@pytest.mark.slow
def test_noise_of_the_believed_covariance_surprises_as_often_as_its_p_value_says() -> None:
    """Of 200 records of noise a tenth or fewer surprise like one in ten, where the observables' variances are as
    uncertain as believed; of noise with the learned variance none fails as a whole.
    """
    draws = np.random.default_rng(4)
    found = [left_over(noise) for noise in believed_noise(200)]
    uncertain = believed_noise(200)
    for noise in uncertain:
        for part in explained()[0].layout:
            noise[part.rows] *= np.exp(0.5 * SCALE * draws.normal())
    tenth = remainder(0.1).log_surprise
    seen = sum(left_over(noise).log_surprise > tenth for noise in uncertain)
    # Blocks share noise, so that the least of them is a little likelier than of independent ones.
    assert binom.ppf(1e-4, 200, 0.05) <= seen <= binom.ppf(0.9999, 200, 0.1)
    assert all(one.passes for one in found)


@pytest.mark.slow
def test_what_exceeds_the_believed_noise_in_one_observable_is_found_there() -> None:
    problem, _ = explained()
    parts = [part for part in problem.layout if part.observable.name in ("stick", "plateau", "slip")]
    for part, noise in zip(parts, believed_noise(3), strict=True):
        noise[part.rows] *= 8.0
        found = left_over(noise)
        assert found.worst_block == part.observable.name
        assert weighed(found.log_surprise).outside > 0.95


def test_a_surprise_goes_to_causes_outside_the_library() -> None:
    outside = [weighed(surprise).outside for surprise in (0.0, 1.0, 3.0, 6.0, 12.0, 600.0)]
    assert outside == sorted(outside)
    assert outside[0] < 1e-100
    assert outside[-1] > 0.999999
    for surprise in (3.0, 6.0):
        assert weighed(surprise).probabilities[()] == pytest.approx(1.0 - weighed(surprise).outside)


@pytest.mark.parametrize(
    ("none", "leading", "seen", "said"),
    [
        (0.55, 0.40, True, True),
        (0.45, 0.30, True, False),
        (0.45, 0.40, False, True),
        (0.40, 0.45, False, False),
        (0.20, 0.15, False, False),
    ],
)
def test_no_gap_is_said_where_it_is_likelier_than_any_class_and_nothing_stands_out(
    none: float, leading: float, seen: bool, said: bool
) -> None:
    assert none_is_likely(none, leading, seen=seen) is said
