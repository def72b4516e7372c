"""Sets of classes by conformal calibration."""

import json
import tomllib
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.stats import binom, kstest

from studies.diagnosis.gap_free_chances import Chance, gap_free_cases, written
from tests.diagnosis_cases import diagnosed, nominal, record, states
from wirewear.diagnosis.calibration import FILE, sources
from wirewear.diagnosis.diagnose import none_is_likely
from wirewear.diagnosis.infer.gate import SCALE, Remainder, remainder_of
from wirewear.diagnosis.infer.inference import Fit, Problem
from wirewear.diagnosis.infer.recognised import LEFT, share_beyond, unrecognised, without
from wirewear.diagnosis.infer.search import search
from wirewear.diagnosis.infer.sets import LEVEL, REACH, before_truth, in_order, masses, plausible, reach_of
from wirewear.diagnosis.infer.weighing import Weighed, weigh
from wirewear.diagnosis.model.candidates import Candidate, library
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.effects import all_effects
from wirewear.effects.roughness_compliance import RoughnessCompliance
from wirewear.views.diagnosis_notes import of_unrecognised

#: A lean of the holder, and a force cell that reads 1.6 % of the load: 0.03 N of 1.2 N.
LEAN = {"stiffness_N_mm_per_rad": 30000.0, "arm_mm": 10.0}
CROSSTALK = 0.016

CYCLES = np.array([1.0, 1e3, 1e5])
SPRING, LAYER, PLAY = ("tangential_compliance",), ("roughness_compliance",), ("free_play",)

KNOWN: dict[tuple[str, ...], float] = {
    ("none",): 0.15,
    ("free_play",): 0.5,
    ("friction_offset",): 0.2,
    ("outside_library",): 0.1,
    ("plasticity",): 0.05,
}


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


@pytest.mark.slow
def test_a_second_effect_is_found_even_where_the_first_leaves_no_more_than_is_expected() -> None:
    both = {"rotational_compliance": LEAN, "force_crosstalk": {"coefficient": CROSSTALK}}
    found = search(states(), nominal("sensor"), reduce(record(both, repeats=1, normal=False, evolution=False)))
    first = max(found.singles, key=lambda one: one.merit)
    left = remainder_of(found.problem, first)
    assert left.misfit < 0.9
    assert left.block_p_value > 0.01
    assert found.best.names == ("tangential_compliance", "force_crosstalk")


@pytest.mark.slow
def test_no_second_effect_is_named_where_there_is_one() -> None:
    lean = record({"rotational_compliance": LEAN}, repeats=1, normal=False, evolution=False)
    assert not search(states(), nominal("sensor"), reduce(lean)).pairs


@pytest.mark.slow
@pytest.mark.parametrize(("likely", "named"), [(4, ("free_play", "normal_load_drift")), (0, ("free_play",))])
def test_what_explains_much_alone_is_fitted_beside_the_first_though_nothing_promises_it_there(
    likely: int, named: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    both = {"free_play": {"gap_um": 3.0}, "normal_load_drift": {"fraction_per_100k_cycles": -0.2}}
    # As if the first, bent to do for both, hid the second: no promise beside it counts.
    monkeypatch.setattr("wirewear.diagnosis.infer.search._SECONDS", 0)
    monkeypatch.setattr("wirewear.diagnosis.infer.search._LIKELY", likely)
    found = search(states(), nominal("sensor"), reduce(record(both, repeats=1, normal=False, evolution=False)))
    assert found.best.names == named


def test_records_like_those_it_was_learned_on_have_uniform_shares() -> None:
    drawn = np.random.default_rng(3).choice(LEFT, 400) + np.random.default_rng(4).normal(0.0, 0.002, 400)
    assert kstest([share_beyond(left) for left in drawn], "uniform").pvalue > 0.05


def test_a_record_that_leaves_more_is_the_rarer_and_none_is_impossible() -> None:
    shares = [share_beyond(left) for left in (0.0, *LEFT, 50.0)]
    assert np.all(np.diff(shares) <= 0.0)
    assert shares[0] < 1.0
    assert shares[-1] == pytest.approx(1.0 / (LEFT.size + 1.0))


def test_as_many_records_of_finite_elements_as_of_the_independent_model_taught_it() -> None:
    assert LEFT.size == 120
    assert "sixty by finer finite elements" in sources()["gap_free_left"]["what"]


def test_what_gap_free_records_leave_is_written_sorted_with_its_commit() -> None:
    found = [Chance("b", 200, 250.0, {}), Chance("a", 100, 80.0, {})]
    entry = tomllib.loads(written(FILE.read_text(encoding="utf-8"), found, "abcdef0"))["infer"]["without_gap"]["left"]
    assert entry == {"value": [0.8, 1.25], "unit": "1", "source": "gap_free_left", "commit": "abcdef0"}


def test_a_score_tells_which_records_have_no_gap(tmp_path: Path) -> None:
    lines = [{"case": "case_001", "kind": "none"}, {"case": "case_002", "kind": "single"}]
    score = tmp_path / "score.json"
    score.write_text(json.dumps({"lines": lines}), encoding="utf-8")
    assert gap_free_cases(score) == {"case_001"}


def layer() -> Candidate:
    return next(one for one in library(nominal()) if one.name == "roughness_compliance")


def fitted(cycles: float, lasting: float) -> Fit:
    """A rough layer of the library that wears in over so many cycles."""
    candidate = layer()
    wanted = {"layer_um": 2.0, "cycles": cycles, "lasting": lasting}
    places = [item.coordinate(wanted[name]) if name in wanted else 0.0 for name, item in candidate.unknowns.items()]
    return Fit((candidate,), np.array(places), np.eye(len(places)), nominal(), 1.0, 0.0)


@pytest.mark.parametrize(
    ("cycles", "lasting", "itself"), [(3e3, 0.01, True), (3e3, 0.5, True), (3e4, 0.01, True), (9e5, 0.6, False)]
)
def test_a_layer_is_one_as_long_as_it_wears_in_within_the_record(cycles: float, lasting: float, itself: bool) -> None:
    """Laws of other form that keep a third or a half of the layer count as layers."""
    found = unrecognised([fitted(cycles, lasting)], CYCLES)
    assert found == ({} if itself else {LAYER: LAYER})


def test_a_layer_that_has_worn_in_before_the_first_loop_is_no_layer_in_the_record() -> None:
    """Between the loops that there are it stays as it is."""
    effect = RoughnessCompliance(layer_um=2.0, cycles=30.0, lasting=0.5)
    assert effect.recognised_between(1.0, 1e5)
    assert not effect.recognised_between(1e3, 1e5)


@pytest.mark.parametrize("cycles", [[], [1e3], [1e3, 1e3]])
def test_loops_of_one_cycle_or_of_none_do_not_say_that_a_layer_stays(cycles: list[float]) -> None:
    assert unrecognised([fitted(9e5, 0.6)], np.array(cycles)) == {}


def test_other_effects_are_what_they_are_named_for() -> None:
    effects = [kind.sized("easy", nominal().stated) for kind in all_effects().values()]
    assert [one.name for one in effects if not one.recognised_between(1.0, 1e5)] == []


def test_what_is_not_recognised_counts_for_a_cause_of_no_library() -> None:
    weighed = Weighed({(): 0.1, LAYER: 0.6, PLAY: 0.1, (*PLAY, *LAYER): 0.1}, 0.1, (LAYER, PLAY))
    found = without(weighed, {LAYER: LAYER, (*PLAY, *LAYER): LAYER})
    assert found.outside == pytest.approx(0.8)
    assert found.probabilities == {(): 0.1, LAYER: 0.0, PLAY: 0.1, (*PLAY, *LAYER): 0.0}


def test_a_layer_that_stays_is_one_class_with_the_spring_that_it_imitates() -> None:
    """The class is right, whichever of its effects fits it best."""
    weighed = Weighed({(): 0.1, LAYER: 0.5, SPRING: 0.4}, 0.0, ((*SPRING, *LAYER),))
    assert without(weighed, {LAYER: LAYER}) == weighed


@given(st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4), st.sets(st.sampled_from([LAYER, SPRING, PLAY])))
def test_no_probability_is_lost(parts: list[float], failing: set[tuple[str]]) -> None:
    weighed = Weighed(dict(zip([(), LAYER, SPRING, PLAY], parts, strict=True)), 0.2, ((*SPRING, *LAYER), PLAY))
    found = without(weighed, {names: names for names in failing})
    assert sum(found.probabilities.values()) + found.outside == pytest.approx(sum(parts) + 0.2)


def test_a_reader_is_told_why_it_is_not_named() -> None:
    (note,) = of_unrecognised(LAYER)
    assert note.startswith("roughness compliance fits best, but does not show")
    assert "vanishes as it wears in" in note
    assert of_unrecognised(()) == ()


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
