"""Sets of classes that hold the cause, and what probabilities make of it."""

import json
from dataclasses import replace
from functools import cache
from importlib.metadata import version

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom

from geometry.arrays import Array
from tests.diagnosis.diagnosis_cases import diagnosed, nominal, record, states
from wirewear import RecordError
from wirewear.base.cache import code_hash
from wirewear.diagnosis import record_diagnosis
from wirewear.diagnosis.answer import Diagnosis
from wirewear.diagnosis.calibration import digest
from wirewear.diagnosis.infer.inference import Fit, Problem
from wirewear.diagnosis.infer.left_open import LEVEL, plausible
from wirewear.diagnosis.infer.search import Search, Updated, search, updated
from wirewear.diagnosis.infer.shrink import shrink_of
from wirewear.diagnosis.infer.weighing import SCALE, Remainder, Weighed, remainder_of
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.diagnosis.preparation import prepared
from wirewear.diagnosis.record_diagnosis import Diagnosed, judged
from wirewear.diagnosis.surrogate.nominal import nominal_study
from wirewear.records import ExperimentRecord
from wirewear.records.tables import Tolerance

#: A lean of the holder, and a force cell that reads 1.6 % of the load: 0.03 N of 1.2 N.
LEAN = {"stiffness_N_mm_per_rad": 30000.0, "arm_mm": 10.0}
CROSSTALK = 0.016
SPRING, LAYER, PLAY = ("tangential_compliance",), ("roughness_compliance",), ("free_play",)
KNOWN: dict[tuple[str, ...], float] = {
    ("none",): 0.15, ("free_play",): 0.5, ("friction_offset",): 0.2, ("outside_library",): 0.1, ("plasticity",): 0.05,
}  # fmt: skip


def remainder(p_value: float, blocks: int = 1) -> Remainder:
    return Remainder(0.5, p_value, blocks)


@cache
def explained() -> tuple[Problem, Fit]:
    """A record without a gap, and the explanation that nothing is the matter."""
    found = diagnosed(record()).search
    return found.problem, found.none


def left_over(noise: Array) -> Remainder:
    """What no effect at all leaves of a record that differs from its prediction by this noise only."""
    problem, nothing = explained()
    return remainder_of(replace(problem, mean=problem.predicted(nothing.setup) + noise), nothing)


def assumed_noise(count: int) -> Array:
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
def test_noise_of_the_stated_covariance_surprises_as_often_as_its_p_value_says() -> None:
    """Of 200 records of noise a tenth or fewer surprise like one in ten, where the observables' variances are as
    uncertain as assumed.
    """
    draws = np.random.default_rng(4)
    uncertain = assumed_noise(200)
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
    left = remainder_of(found.problem, max(found.singles, key=lambda one: one.merit))
    assert left.misfit < 0.9
    assert left.block_p_value > 0.01
    assert found.best.names == ("tangential_compliance", "force_crosstalk")


@given(st.lists(st.floats(0.01, 1.0), min_size=5, max_size=5), st.sampled_from([None, LAYER, SPRING, PLAY]))
def test_the_verdict_never_contradicts_the_probabilities(parts: list[float], failing: tuple[str] | None) -> None:
    *own, outside = np.array(parts) / sum(parts)
    found = Weighed(dict(zip([(), LAYER, SPRING, PLAY], own, strict=True)), outside, ((*SPRING, *LAYER), PLAY))
    if failing:
        apart, found = found.withdrawn(failing), found.refuted(failing)
        assert found.mass(failing) == apart.mass(failing) == 0.0
        assert apart.probabilities[()] == pytest.approx(own[0] + found.outside - outside)
    said = {"no_gap": found.probabilities[()], "unexplained": found.outside}.get(found.verdict, found.leading)
    assert said == max(found.probabilities[()], found.outside, found.mass(SPRING), found.mass(PLAY))


@given(st.lists(st.floats(0.01, 1.0), min_size=5, max_size=5))
def test_a_set_has_the_level_less_without_its_last_class_and_a_cause_of_no_library(parts: list[float]) -> None:
    known = dict(zip(KNOWN, (np.array(parts) / sum(parts)).tolist(), strict=True))
    *others, last = found = plausible(known)
    assert ("outside_library",) in found
    assert sum(known[members] for members in found) >= LEVEL - 1e-9
    if last != ("outside_library",):
        assert sum(known[members] for members in others) < LEVEL


#: A play that a record of little scatter shows, and that turns the loop 0.25 µm late on either flank, of 60 µm.
PLAY_um = 0.5


@cache
def found() -> Diagnosed:
    return diagnosed(record({"free_play": {"gap_um": PLAY_um}}, scatter=0.2))


def tolerant(displacement: float, search: Search | None = None) -> Diagnosis:
    one = found()
    tables = one.record.tables.model_copy(update={"tolerance": Tolerance(displacement=displacement)})
    record = replace(one.record, tables=tables)
    return judged(record, one.study, one.states, one.observed, search or one.search).diagnosis


@pytest.mark.seconds
def test_a_difference_within_the_tolerance_is_no_gap_and_is_stated_with_its_size() -> None:
    answer = tolerant(0.01)
    assert answer.verdict == "no_gap"
    assert (answer.causes[0].effect, answer.causes[0].probability) == ("none", 1.0)
    relevance = answer.to_json()["relevance"]
    assert (relevance["detected"], relevance["relevant"]) == (True, False)
    assert {name for members in answer.plausible for name in members} >= {"none", "free_play"}
    # A flank is late by half of the play or, where the other one reaches into it, by more, up to the whole of it.
    assert 0.5 * PLAY_um <= 60.0 * relevance["largest"]["relative"] <= PLAY_um
    assert "free play" in answer.sentence
    assert "tolerance" in answer.sentence


@pytest.mark.seconds
def test_the_same_difference_beyond_a_finer_tolerance_has_its_cause() -> None:
    answer = tolerant(0.002)
    assert answer.verdict == "explained"
    assert answer.causes[0].effect == "free_play"
    assert answer.to_json()["relevance"]["relevant"] is True


@pytest.mark.seconds
@pytest.mark.parametrize(("instead", "verdict"), [(True, "unexplained"), (False, "explained")])
def test_an_unknown_cause_acts_instead_of_what_leaves_little_not_beside_it(instead: bool, verdict: str) -> None:
    search = found().search
    beside = search.none if instead else search.best
    gain = search.best.log_evidence - beside.log_evidence + 60.0
    distortion = replace(next(one for one in search.distortions if one.family.counts), beside=beside, gain=gain)
    assert tolerant(0.001, replace(search, distortions=(distortion,))).verdict == verdict


@pytest.mark.seconds
@pytest.mark.parametrize(("p_value", "verdict"), [(0.5, "no_gap"), (1e-6, "unexplained")])
def test_a_cause_not_borne_out_leaves_no_gap_only_where_chance_would(
    p_value: float, verdict: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(record_diagnosis, "shrink_of", lambda *given: replace(shrink_of(*given), borne_out=False))
    monkeypatch.setattr(record_diagnosis, "remainder_of", lambda *_: remainder(p_value))
    assert tolerant(0.002).verdict == verdict


@pytest.mark.seconds
def test_the_json_has_all_keys_of_its_format() -> None:
    data = json.loads(json.dumps(found().diagnosis.to_json(), allow_nan=False))
    assert set(data) >= {
        "format", "record", "model", "program", "verdict", "gap", "where", "causes", "equivalent", "undetectable",
        "next_measurement", "resembles", "partial", "checked",
    }  # fmt: skip
    assert set(data["gap"]) == {
        "before", "after", "floor", "shrink", "shrink_interval95", "predicted_shrink", "held_out", "placebo_shrink",
        "physical", "confirmed",
    }  # fmt: skip
    assert set(data["gap"]["physical"]) == {
        "slip_amplitude_um", "dissipated_energy_percent", "tangential_force_rms_N",
    }  # fmt: skip
    assert data["program"] == {"version": version("wirewear"), "sources": code_hash(), "calibration": digest()}
    for finding in data["where"]:
        assert set(finding) == {"observable", "zone", "cycles", "share", "size_in_scatter", "text"}
    assert sum(cause["probability"] for cause in data["causes"]) <= 1.0 + 1e-6


EFFECTS = {
    "none": {},
    "spring": {"tangential_compliance": {"stiffness_N_per_mm": 400.0}},
    "sensor": {"displacement_load_coupling": {"linear_um_per_N": 2.5, "quadratic_um_per_N2": 0.0}},
}


@cache
def searched(one: ExperimentRecord) -> Search:
    """The search on the states of the made-up wires."""
    return search(states(), nominal(one.tables.conditions.drive), reduce(one))


def diagnosis_of(first: ExperimentRecord, *further: ExperimentRecord) -> Diagnosis:
    """The answer to a record, updated by others, on the states of the made-up wires."""
    found = searched(first)
    for other in further:
        found = updated(found, states(), nominal(other.tables.conditions.drive), reduce(other))
    return judged(first, nominal_study(first), states(), reduce(first), found, further).diagnosis


@cache
def one_loop(effect: str, drive: str, seed: int, cycle: int) -> ExperimentRecord:
    """A record that says as little as one can."""
    return record(EFFECTS[effect], repeats=1, seed=seed, drive=drive, evolution=False, normal=False, cycles=(cycle,))


@pytest.mark.slow
def test_a_stroke_held_by_an_encoder_separates_a_sensor_from_a_spring() -> None:
    (group,) = diagnosis_of(one_loop("sensor", "sensor", 1, 100)).equivalent
    assert {"tangential_compliance", "displacement_load_coupling"} <= set(group)
    both = diagnosis_of(one_loop("sensor", "sensor", 1, 100), one_loop("sensor", "stroke", 2, 100))
    assert both.equivalent == ()
    assert both.causes[0].effect == "displacement_load_coupling"
    assert both.causes[0].probability > 0.95
    spring = diagnosis_of(one_loop("spring", "sensor", 1, 100), one_loop("spring", "stroke", 2, 100))
    assert spring.causes[0].effect == "tangential_compliance"
    assert not any("displacement_load_coupling" in members for members in spring.equivalent)


@pytest.mark.slow
def test_two_records_of_a_test_say_what_one_of_two_repeats_says() -> None:
    first, second = (record(EFFECTS["spring"], repeats=1, seed=seed, cycles=(100, 10_000)) for seed in (1, 2))
    loops = (*first.loops, *(replace(loop, repeat=2) for loop in second.loops))
    evolution = (*first.evolution, *(replace(one, repeat=2) for one in second.evolution))
    together = diagnosis_of(replace(first, loops=loops, evolution=evolution))
    apart = diagnosis_of(first, second)
    one, other = (answer.causes[0].parameters["stiffness_N_per_mm"] for answer in (together, apart))
    alone = diagnosis_of(first).causes[0].parameters["stiffness_N_per_mm"]
    widths = [np.diff(np.log(each.interval95))[0] for each in (one, other, alone)]
    assert other.value == pytest.approx(one.value, rel=0.03)
    assert widths[1] == pytest.approx(widths[0], rel=0.3)
    assert widths[1] < 0.85 * widths[2]
    assert apart.to_json()["updated_by"] == [second.name]


@pytest.mark.slow
def test_a_record_without_a_gap_stays_so_with_another_one() -> None:
    answer = diagnosis_of(one_loop("none", "sensor", 1, 100), one_loop("none", "stroke", 2, 1000))
    assert answer.verdict == "no_gap"


@pytest.mark.slow
def test_a_gap_that_a_further_record_does_not_show_is_no_effect_of_the_rig() -> None:
    answer = diagnosis_of(one_loop("spring", "sensor", 1, 100), one_loop("none", "sensor", 2, 100))
    assert answer.verdict != "explained"


def test_a_search_holds_every_further_record_but_the_same_loops_are_none() -> None:
    found, other = searched(one_loop("spring", "sensor", 1, 100)), one_loop("none", "sensor", 2, 100)
    for count in (1, 2):
        found = updated(found, states(), nominal(other.tables.conditions.drive), reduce(other))
        assert isinstance(found, Updated)
        assert len(found.further) == len(found.before) == count
    first = one_loop("none", "sensor", 1, 100)
    with pytest.raises(RecordError, match="is diagnosed alone"):
        prepared(first, further=[first])
