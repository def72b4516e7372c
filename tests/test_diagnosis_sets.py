"""Sets of classes by conformal calibration."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom

from geometry.arrays import Array
from tests.diagnosis_cases import diagnosed, nominal, record, states
from wirewear.diagnosis.infer.inference import Fit, Problem
from wirewear.diagnosis.infer.search import search
from wirewear.diagnosis.infer.sets import LEVEL, REACH, before_truth, in_order, plausible, reach_of
from wirewear.diagnosis.infer.weighing import SCALE, Remainder, Weighed, remainder_of, weigh, without
from wirewear.diagnosis.observe.reduction import reduce

#: A lean of the holder, and a force cell that reads 1.6 % of the load: 0.03 N of 1.2 N.
LEAN = {"stiffness_N_mm_per_rad": 30000.0, "arm_mm": 10.0}
CROSSTALK = 0.016

SPRING, LAYER, PLAY = ("tangential_compliance",), ("roughness_compliance",), ("free_play",)

KNOWN: dict[tuple[str, ...], float] = {
    ("none",): 0.15,
    ("free_play",): 0.5,
    ("friction_offset",): 0.2,
    ("outside_library",): 0.1,
    ("plasticity",): 0.05,
}


def remainder(p_value: float, blocks: int = 1) -> Remainder:
    return Remainder(0.5, p_value, blocks)


def weighed(log_surprise: float) -> Weighed:
    nothing = Fit((), np.zeros(0), np.zeros((0, 0)), nominal(), 100.0, -50.0)
    return weigh(nothing, (), (), (), 1.0, log_surprise)


@cache
def explained() -> tuple[Problem, Fit]:
    """A record without a gap, and the explanation that nothing is the matter."""
    found = diagnosed(record()).search
    return found.problem, found.none


def left_over(noise: Array) -> Remainder:
    """What no effect at all leaves of a record that differs from its prediction by this noise only."""
    problem, nothing = explained()
    return remainder_of(replace(problem, mean=problem.predicted(nothing.setup) + noise), nothing)


def believed_noise(count: int) -> Array:
    """Draws (count, n) from the covariance that the diagnosis assumes."""
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


@pytest.mark.slow
def test_noise_of_the_believed_covariance_surprises_as_often_as_its_p_value_says() -> None:
    """Of 200 records of noise a tenth or fewer surprise like one in ten, where the observables' variances are as
    uncertain as believed.
    """
    draws = np.random.default_rng(4)
    uncertain = believed_noise(200)
    for noise in uncertain:
        for part in explained()[0].layout:
            noise[part.rows] *= np.exp(0.5 * SCALE * draws.normal())
    tenth = remainder(0.1).log_surprise
    seen = sum(left_over(noise).log_surprise > tenth for noise in uncertain)
    # Blocks share noise, so that the least of them is a little likelier than of independent ones.
    assert binom.ppf(1e-4, 200, 0.05) <= seen <= binom.ppf(0.9999, 200, 0.1)


@pytest.mark.slow
def test_a_second_effect_is_found_even_where_the_first_leaves_no_more_than_is_expected() -> None:
    both = {"rotational_compliance": LEAN, "force_crosstalk": {"coefficient": CROSSTALK}}
    found = search(states(), nominal("sensor"), reduce(record(both, repeats=1, normal=False, evolution=False)))
    first = max(found.singles, key=lambda one: one.merit)
    left = remainder_of(found.problem, first)
    assert left.misfit < 0.9
    assert left.block_p_value > 0.01
    assert found.best.names == ("tangential_compliance", "force_crosstalk")


@given(st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4), st.sets(st.sampled_from([LAYER, SPRING, PLAY])))
def test_no_probability_is_lost(parts: list[float], failing: set[tuple[str]]) -> None:
    weighed = Weighed(dict(zip([(), LAYER, SPRING, PLAY], parts, strict=True)), 0.2, ((*SPRING, *LAYER), PLAY))
    found = without(weighed, {names: names for names in failing})
    assert sum(found.probabilities.values()) + found.outside == pytest.approx(sum(parts) + 0.2)


@given(st.lists(st.floats(0.01, 1.0), min_size=5, max_size=5), st.sampled_from([None, LAYER, SPRING, PLAY]))
def test_the_verdict_never_contradicts_the_probabilities(parts: list[float], failing: tuple[str] | None) -> None:
    *own, outside = np.array(parts) / sum(parts)
    found = Weighed(dict(zip([(), LAYER, SPRING, PLAY], own, strict=True)), outside, ((*SPRING, *LAYER), PLAY))
    if failing:
        found = found.refuted(failing)
        assert found.mass(failing) == 0.0
    said = {"no_gap": found.probabilities[()], "unexplained": found.outside}.get(found.verdict, found.leading)
    assert said == max(found.probabilities[()], found.outside, found.mass(SPRING), found.mass(PLAY))


@pytest.mark.parametrize("verdict", REACH)
def test_a_set_is_a_beginning_of_the_order_and_never_empty(verdict: str) -> None:
    kept, order = plausible(verdict, KNOWN), in_order(verdict, KNOWN)
    assert kept == order[: len(kept)]
    assert kept


def test_a_set_holds_the_truth_where_no_more_than_its_reach_lies_before_it() -> None:
    for verdict in REACH:
        for members in KNOWN:
            held = members in plausible(verdict, KNOWN)
            assert held == (before_truth(verdict, KNOWN, members) <= REACH[verdict])


def test_sets_hold_as_often_as_their_level_whatever_the_probabilities_are_worth() -> None:
    random = np.random.default_rng(3)
    held, tried = 0, 400
    for _ in range(tried):
        befores = (random.random(41) ** 3).tolist()
        held += befores[-1] <= reach_of(befores[:-1], LEVEL)
    assert abs(held / tried - LEVEL) < 4.0 * np.sqrt(LEVEL * (1.0 - LEVEL) / tried) + 1.0 / 41.0
