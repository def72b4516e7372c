"""Diagnosis of records that the fast model made itself: verdicts, causes, parameters, shrink and the JSON of it."""

import json
from functools import cache

import pytest

from tests.diagnosis_cases import CYCLES, diagnosed, record
from wirewear.diagnosis import Diagnosis
from wirewear.diagnosis.report.diagnosed import Diagnosed
from wirewear.diagnosis.report.page import ten_lines

PLAY_um, COMPLIANCE_N_per_mm = 3.0, 300.0


@cache
def gap_free() -> Diagnosed:
    return diagnosed(record())


@cache
def with_play() -> Diagnosed:
    return diagnosed(record({"free_play": {"gap_um": PLAY_um}}))


@cache
def with_compliance() -> Diagnosed:
    return diagnosed(record({"tangential_compliance": {"stiffness_N_per_mm": COMPLIANCE_N_per_mm}}))


@cache
def early_only() -> Diagnosed:
    """Friction that starts low, seen by loops alone in one repeat."""
    effect = {"friction_evolution": {"initial": 0.45, "final": 0.62, "cycles": 3000.0}}
    return diagnosed(record(effect, repeats=1, evolution=False, normal=False))


#: One of them among the fast tests: each takes seconds.
ANSWERS = [*(pytest.param(answer, marks=pytest.mark.slow) for answer in (gap_free, with_play)), with_compliance]


def probability(diagnosis: Diagnosis, effect: str) -> float:
    return sum(cause.probability for cause in diagnosis.causes if cause.effect == effect)


@pytest.mark.slow
def test_a_record_of_the_model_itself_has_no_gap() -> None:
    diagnosis = gap_free().diagnosis
    assert diagnosis.verdict == "no_gap"
    assert diagnosis.where == ()
    assert diagnosis.causes[0].effect == "none"


@pytest.mark.slow
def test_play_is_named_with_its_width() -> None:
    diagnosis = with_play().diagnosis
    assert diagnosis.verdict == "explained"
    assert diagnosis.causes[0].effect == "free_play"
    gap = diagnosis.causes[0].parameters["gap_um"]
    assert gap.value == pytest.approx(PLAY_um, rel=0.1)
    assert gap.interval95[0] < PLAY_um < gap.interval95[1]


def test_a_compliance_is_named_as_a_class_that_holds_rotation() -> None:
    diagnosis = with_compliance().diagnosis
    assert diagnosis.verdict == "explained"
    (members,) = (members for members in diagnosis.equivalent if "tangential_compliance" in members)
    assert "rotational_compliance" in members
    assert "rotational compliance" in diagnosis.sentence
    assert "cannot tell apart" in diagnosis.sentence
    assert probability(diagnosis, "rotational_compliance") > 0.1


def test_the_stiffness_of_a_compliance_lies_in_its_interval() -> None:
    (cause,) = (c for c in with_compliance().diagnosis.causes if c.effect == "tangential_compliance")
    estimate = cause.parameters["stiffness_N_per_mm"]
    assert estimate.value == pytest.approx(COMPLIANCE_N_per_mm, rel=0.05)
    assert estimate.interval95[0] < COMPLIANCE_N_per_mm < estimate.interval95[1]


def test_a_compliance_asks_for_a_measurement_that_splits_its_class() -> None:
    following = with_compliance().diagnosis.next_measurement
    assert following is not None
    assert {"tangential_compliance", "displacement_load_coupling"} <= set(following["splits"])


def test_the_gap_shrinks_to_its_floor_on_cycles_left_out_of_the_fit() -> None:
    shrink = with_compliance().diagnosis.shrink
    assert shrink.held_out == CYCLES[-1:]
    assert shrink.before > 2.0 * shrink.floor
    assert shrink.after <= 1.2 * shrink.floor
    assert shrink.shrink == pytest.approx(1.0, abs=0.02)
    assert shrink.free_smooth_fit is not None
    assert shrink.free_smooth_fit < shrink.shrink


def test_the_map_finds_a_compliance_where_the_contact_sticks() -> None:
    (first, *_) = with_compliance().diagnosis.where
    assert (first.observable, first.zone) == ("displacement at equal force", "stick")


@pytest.mark.slow
def test_loops_of_one_repeat_suffice_and_the_answer_says_what_that_costs() -> None:
    diagnosis = early_only().diagnosis
    assert diagnosis.verdict == "explained"
    assert diagnosis.causes[0].effect == "friction_evolution"
    assert any("one repeat only" in note for note in diagnosis.notes)


@pytest.mark.slow
def test_what_only_shows_early_is_scored_on_cycles_between() -> None:
    shrink = early_only().diagnosis.shrink
    assert shrink.held_out == CYCLES[::2]
    assert shrink.before > shrink.floor
    assert shrink.shrink > 0.9


@pytest.mark.slow
def test_an_effect_that_is_left_out_of_the_library_is_not_named() -> None:
    one = record({"free_play": {"gap_um": PLAY_um}})
    diagnosis = diagnosed(one, "free_play").diagnosis
    assert diagnosis.verdict in ("unexplained", "ambiguous")
    assert probability(diagnosis, "free_play") == 0.0


@pytest.mark.slow
def test_the_same_record_gives_the_same_answer_to_the_last_digit() -> None:
    again = diagnosed(record({"free_play": {"gap_um": PLAY_um}})).diagnosis
    assert json.dumps(again.to_json()) == json.dumps(with_play().diagnosis.to_json())


@pytest.mark.parametrize("answer", ANSWERS)
def test_the_json_has_all_keys_of_its_format(answer: object) -> None:
    assert callable(answer)
    data = json.loads(json.dumps(answer().diagnosis.to_json(), allow_nan=False))
    assert set(data) >= {
        "format", "record", "model", "verdict", "gap", "where", "causes", "equivalent", "undetectable",
        "next_measurement",
    }  # fmt: skip
    assert set(data["gap"]) == {
        "before", "after", "floor", "shrink", "shrink_interval95", "predicted_shrink", "held_out", "placebo_shrink",
        "physical", "confirmed",
    }  # fmt: skip
    assert set(data["gap"]["physical"]) == {
        "slip_amplitude_um", "dissipated_energy_percent", "tangential_force_rms_N",
    }  # fmt: skip
    for finding in data["where"]:
        assert set(finding) == {"observable", "zone", "cycles", "share", "size_in_scatter", "text"}
    assert sum(cause["probability"] for cause in data["causes"]) <= 1.0 + 1e-6


@pytest.mark.parametrize("answer", ANSWERS)
def test_the_answer_for_a_terminal_has_at_most_ten_lines(answer: object) -> None:
    assert callable(answer)
    assert 3 <= len(ten_lines(answer().diagnosis).splitlines()) <= 10
