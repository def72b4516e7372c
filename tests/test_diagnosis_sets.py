"""Sets of classes by conformal calibration."""

import numpy as np
import pytest

from wirewear.diagnosis.infer.sets import LEVEL, REACH, before_truth, in_order, masses, plausible, reach_of

KNOWN: dict[tuple[str, ...], float] = {
    ("none",): 0.15,
    ("free_play",): 0.5,
    ("friction_offset",): 0.2,
    ("outside_library",): 0.1,
    ("plasticity",): 0.05,
}


def test_effects_that_cannot_be_told_apart_are_one_class_of_their_whole_probability() -> None:
    found = masses([("free_play", 0.4), ("sensor_lag", 0.3), ("none", 0.2)], [("free_play", "sensor_lag")])
    assert found == {("free_play", "sensor_lag"): pytest.approx(0.7), ("none",): 0.2}


def test_what_the_verdict_says_stands_first_whatever_its_probability() -> None:
    assert in_order("unexplained", KNOWN)[:2] == (("outside_library",), ("free_play",))
    assert in_order("no_gap", KNOWN)[0] == ("none",)
    assert in_order("explained", KNOWN)[0] == ("free_play",)


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


def test_what_cannot_be_seen_is_in_the_set_where_no_gap_was_and_nowhere_else() -> None:
    unseen = ("wear_rate_offset", "plasticity")
    kept = plausible("no_gap", KNOWN, unseen)
    assert {("wear_rate_offset",), ("plasticity",)} <= set(kept)
    assert len(kept) == len(set(kept))
    assert before_truth("no_gap", KNOWN, ("plasticity",), unseen) == 0.0
    for verdict in set(REACH) - {"no_gap"}:
        assert plausible(verdict, KNOWN, unseen) == plausible(verdict, KNOWN)


def test_sets_hold_as_often_as_their_level_whatever_the_probabilities_are_worth() -> None:
    random = np.random.default_rng(3)
    held, tried = 0, 400
    for _ in range(tried):
        befores = (random.random(41) ** 3).tolist()
        held += befores[-1] <= reach_of(befores[:-1], LEVEL)
    assert abs(held / tried - LEVEL) < 4.0 * np.sqrt(LEVEL * (1.0 - LEVEL) / tried) + 1.0 / 41.0


def test_too_few_records_leave_nothing_out() -> None:
    assert reach_of([0.0] * 8, 0.9) == 2.0
    assert reach_of([0.0] * 9, 0.9) == 0.0
