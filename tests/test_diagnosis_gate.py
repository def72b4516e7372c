"""The gate before a name: what an explanation leaves over, as evidence for a cause outside the library."""

from math import e, exp, log

import numpy as np
import pytest

from tests.diagnosis_cases import nominal
from wirewear.diagnosis.diagnose import none_is_likely
from wirewear.diagnosis.infer.gate import Remainder
from wirewear.diagnosis.infer.inference import Fit
from wirewear.diagnosis.infer.weighing import PRIOR_NONE, PRIOR_OUTSIDE, Weighed, weigh


def remainder(p_value: float, blocks: int = 1) -> Remainder:
    return Remainder(0.5, "stick", p_value, 1.0, blocks)


def weighed(log_surprise: float) -> Weighed:
    nothing = Fit((), np.zeros(0), np.zeros((0, 0)), nominal(), 100.0, -50.0)
    return weigh(nothing, (), (), -1000.0, (), 1.0, log_surprise)


def test_a_remainder_that_chance_explains_is_no_surprise() -> None:
    assert remainder(0.5).log_surprise == 0.0
    assert remainder(0.08, blocks=10).log_surprise == 0.0


def test_the_surprise_is_the_bound_on_the_bayes_factor() -> None:
    assert remainder(0.01).log_surprise == pytest.approx(-log(-e * 0.01 * log(0.01)))
    assert remainder(0.001, blocks=10).log_surprise == pytest.approx(remainder(0.00996).log_surprise, abs=2e-3)
    assert remainder(0.0).log_surprise > 600.0


def test_the_less_likely_the_remainder_the_larger_the_surprise() -> None:
    surprises = [remainder(p, blocks=8).log_surprise for p in (1e-2, 1e-4, 1e-8, 1e-20)]
    assert surprises == sorted(surprises)


def test_a_surprise_goes_to_causes_outside_the_library() -> None:
    assert weighed(0.0).outside < 1e-100
    odds = PRIOR_OUTSIDE / (1.0 - PRIOR_NONE - PRIOR_OUTSIDE) * (exp(6.0 / 2.0) - 1.0)
    assert weighed(6.0).outside == pytest.approx(odds / (1.0 + odds))
    assert weighed(6.0).probabilities[()] == pytest.approx(1.0 / (1.0 + odds))


@pytest.mark.parametrize(
    ("none", "leading", "seen", "said"),
    [
        (0.55, 0.40, True, True),
        (0.45, 0.30, True, False),
        (0.45, 0.30, False, True),
        (0.30, 0.60, False, False),
        (0.20, 0.15, False, False),
        (0.51, 0.49, False, True),
    ],
)
def test_no_gap_is_said_where_it_is_likelier_than_all_else_and_nothing_stands_out(
    none: float, leading: float, seen: bool, said: bool
) -> None:
    assert none_is_likely(none, leading, seen=seen) is said


def test_a_cause_outside_the_library_may_look_like_one_of_it() -> None:
    sure = Weighed({(): 0.0, ("free_play",): 1.0}, 0.0, (("free_play",),)).stated
    assert sure.outside == pytest.approx(34 / 307)
    open_ = Weighed({(): 0.5, ("free_play",): 0.2}, 0.3, (("free_play",),)).stated
    assert sum(open_.probabilities.values()) + open_.outside == pytest.approx(1.0)
    assert open_.probabilities[()] / open_.probabilities["free_play",] == pytest.approx(2.5)
    assert 0.3 < open_.outside < 0.4
    certain = Weighed({(): 0.0, ("free_play",): 0.0}, 1.0, (("free_play",),)).stated
    assert certain.outside == 1.0
