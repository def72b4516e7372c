"""Diagnosis of records that an independent forward model made: verdicts, causes, parameters, shrink and the JSON of it.

The nominal model is the program's own, its wear states frozen; nothing of what made the records is known to it.
"""

import json
from functools import cache
from importlib.metadata import version

import numpy as np
import pytest

from tests.diagnosis_cases import CYCLES
from tests.frozen_states import frozen_states, present_states
from tests.independent_records import independent_record
from wirewear.base.identity import code_hash
from wirewear.diagnosis import Diagnosis
from wirewear.diagnosis.calibration import digest
from wirewear.diagnosis.diagnose import concluded
from wirewear.diagnosis.infer.covariance import estimate, with_forms
from wirewear.diagnosis.infer.inference import Problem
from wirewear.diagnosis.model.candidates import nominal_setup
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.nominal import nominal_study, wearing
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.records import ExperimentRecord
from wirewear.study import Study
from wirewear.views.diagnosis_wording import Diagnosed

PLAY_um, COMPLIANCE_N_per_mm = 3.0, 300.0
PLAY = {"free_play": {"gap_um": PLAY_um}}


def diagnosed(one: ExperimentRecord, *left_out: str) -> Diagnosed:
    return concluded(one, nominal_study(one), frozen_states(), reduce(one), left_out)


def without_wear(one: ExperimentRecord) -> Study:
    study: Study = nominal_study(one)
    return study.changed({"wear": {"energy_wear_coefficient_mm3_per_J": 0.0}})


def test_a_model_without_wear_has_wear_states() -> None:
    one = independent_record(repeats=1, evolution=False)
    worn, fresh = nominal_study(one), without_wear(one)
    assert wearing(worn) is worn
    bare = fresh.changed({"wear": None})
    assert bare.wear is None
    assert wearing(bare).wear == wearing(fresh).wear
    given = wearing(fresh)
    assert given.wear is not None
    coefficient = given.wear.energy_wear_coefficient_mm3_per_J
    assert coefficient is not None
    # 60 µm of 0.225 mm wires: V = δ⁴/R over ΣE = 4 µ P δ N.
    energy_J = 4e-6 * 0.62 * 2.0 * 60.0 * one.tables.conditions.cycles
    assert coefficient * energy_J == pytest.approx(0.06**4 / 0.225, rel=0.01)


@cache
def gap_free() -> Diagnosed:
    return diagnosed(independent_record())


@cache
def with_play() -> Diagnosed:
    return diagnosed(independent_record(PLAY))


@cache
def with_compliance() -> Diagnosed:
    return diagnosed(independent_record({"tangential_compliance": {"stiffness_N_per_mm": COMPLIANCE_N_per_mm}}))


def probability(diagnosis: Diagnosis, effect: str) -> float:
    return sum(cause.probability for cause in diagnosis.causes if cause.effect == effect)


@pytest.mark.slow
def test_another_solvers_record_without_an_effect_has_no_gap() -> None:
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


@pytest.mark.slow
def test_a_compliance_is_named_as_a_class_that_holds_rotation() -> None:
    diagnosis = with_compliance().diagnosis
    assert diagnosis.verdict == "explained"
    (members,) = (members for members in diagnosis.equivalent if "tangential_compliance" in members)
    assert "rotational_compliance" in members
    assert "rotational compliance" in diagnosis.sentence
    assert "cannot tell apart" in diagnosis.sentence
    assert probability(diagnosis, "rotational_compliance") > 0.1


@pytest.mark.slow
def test_the_stiffness_of_a_compliance_lies_in_its_interval() -> None:
    (cause,) = (c for c in with_compliance().diagnosis.causes if c.effect == "tangential_compliance")
    estimate = cause.parameters["stiffness_N_per_mm"]
    assert estimate.value == pytest.approx(COMPLIANCE_N_per_mm, rel=0.05)
    assert estimate.interval95[0] < COMPLIANCE_N_per_mm < estimate.interval95[1]


@pytest.mark.seconds
def test_a_compliance_asks_for_a_measurement_that_splits_its_class() -> None:
    following = with_compliance().diagnosis.next_measurement
    assert following is not None
    assert {"tangential_compliance", "displacement_load_coupling"} <= set(following["splits"])


@pytest.mark.seconds
def test_the_gap_shrinks_to_its_floor_on_cycles_left_out_of_the_fit() -> None:
    shrink = with_compliance().diagnosis.shrink
    assert shrink.held_out == CYCLES[-1:]
    assert shrink.before > 2.0 * shrink.floor
    assert shrink.after <= 1.2 * shrink.floor
    assert shrink.shrink == pytest.approx(1.0, abs=0.02)
    assert shrink.free_smooth_fit is not None
    assert shrink.free_smooth_fit < shrink.shrink


@pytest.mark.slow
def test_a_wrong_crossing_angle_is_named_from_the_scars() -> None:
    record = independent_record({"crossing_angle_error": {"angle_deg": 5.0}}, scars=True)
    diagnosis = diagnosed(record).diagnosis
    assert diagnosis.verdict == "explained"
    (angle,) = (c.parameters["angle_deg"] for c in diagnosis.causes if c.effect == "crossing_angle_error")
    assert angle.interval95[0] < 5.0 < angle.interval95[1]
    assert diagnosis.shrink.scar_held_out


@pytest.mark.slow
def test_whitened_residuals_of_gap_free_records_are_standard_deviates_at_most() -> None:
    """Solvers may differ by less than the covariance allows, never by more."""
    for seed in (2, 3, 4):
        one = independent_record(seed=seed)
        observed, setup = reduce(one), nominal_setup(nominal_study(one), "sensor")
        believed = estimate(frozen_states(), setup, observed)
        covariance = with_forms(frozen_states(), setup, observed.layout, believed, fitted=0)
        whitened = Problem.of(frozen_states(), setup, observed.layout, covariance).whitened(setup)
        assert float((whitened**2).mean()) < 1.3
        assert abs(whitened).max() < 4.5


@pytest.mark.slow
def test_the_frozen_states_are_those_of_a_run_made_now() -> None:
    """Within what solvers may differ by; otherwise `python -m tests.frozen_states` is due."""
    record = independent_record()
    observed, setup = reduce(record), nominal_setup(nominal_study(record), "sensor")
    frozen, present = (
        observed.layout.observed(simulate(states, setup, observed.layout.cycles))
        for states in (frozen_states(), present_states(record))
    )
    covariance = estimate(frozen_states(), setup, observed)
    deviations = np.sqrt(np.diag(covariance.numerical + covariance.tolerated))
    assert (abs(present - frozen) / deviations).max() < 1.0


@pytest.mark.slow
def test_the_same_record_gives_the_same_answer_to_the_last_digit() -> None:
    again = diagnosed(independent_record(PLAY)).diagnosis
    assert json.dumps(again.to_json()) == json.dumps(with_play().diagnosis.to_json())


@pytest.mark.seconds
def test_the_json_has_all_keys_of_its_format() -> None:
    data = json.loads(json.dumps(with_compliance().diagnosis.to_json(), allow_nan=False))
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
