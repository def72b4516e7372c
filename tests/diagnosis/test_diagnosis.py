"""Diagnosis of records that an independent forward model made: verdicts, causes, parameters, shrink and the JSON of it.

The nominal model is the program's own, its wear states frozen; nothing of what made the records is known to it.
"""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.arrays import Array
from tests.diagnosis.diagnosis_cases import CYCLES, NOISE_N, concluded, nominal, record
from tests.exam.frozen_states import frozen_states, present_states
from tests.exam.independent_records import independent_record
from tests.studies import EXAMPLES
from tests.synthetic_results import loop, result
from wirewear.diagnosis import Diagnosis, diagnose
from wirewear.diagnosis.infer.covariance import estimate
from wirewear.diagnosis.infer.inference import Problem, fit
from wirewear.diagnosis.observe.along_branches import PlateauForce
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.diagnosis.record_diagnosis import Diagnosed
from wirewear.diagnosis.surrogate.forward import simulate
from wirewear.diagnosis.surrogate.loop_states import scar_skew, skew_and_noise
from wirewear.diagnosis.surrogate.nominal import nominal_study, wearing
from wirewear.diagnosis.surrogate.nominal_model import nominal_inputs
from wirewear.diagnosis.surrogate.wear_states import WearStates
from wirewear.records import ExperimentRecord, read_record
from wirewear.results import RunResult

PLAY_um, COMPLIANCE_N_per_mm = 3.0, 300.0
PLAY = {"free_play": {"gap_um": PLAY_um}}


def concluded_of(one: ExperimentRecord, *left_out: str) -> Diagnosed:
    return concluded(one, nominal_study(one), frozen_states(), reduce(one), left_out)


def test_a_model_without_wear_has_wear_states() -> None:
    one = independent_record(repeats=1, evolution=False)
    worn = nominal_study(one)
    fresh = worn.changed({"wear": {"energy_wear_coefficient_mm3_per_J": 0.0}})
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
def with_play() -> Diagnosed:
    return concluded_of(independent_record(PLAY))


@cache
def with_compliance() -> Diagnosed:
    return concluded_of(independent_record({"tangential_compliance": {"stiffness_N_per_mm": COMPLIANCE_N_per_mm}}))


def probability(diagnosis: Diagnosis, effect: str) -> float:
    return sum(cause.probability for cause in diagnosis.causes if cause.effect == effect)


@pytest.mark.slow
def test_another_solvers_record_without_an_effect_has_no_gap() -> None:
    diagnosis = concluded_of(independent_record()).diagnosis
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
    assert "cannot distinguish" in diagnosis.sentence
    assert probability(diagnosis, "rotational_compliance") > 0.1


@pytest.mark.slow
def test_the_stiffness_of_a_compliance_lies_in_its_interval() -> None:
    (cause,) = (c for c in with_compliance().diagnosis.causes if c.effect == "tangential_compliance")
    estimate = cause.parameters["stiffness_N_per_mm"]
    assert estimate.value == pytest.approx(COMPLIANCE_N_per_mm, rel=0.05)
    assert estimate.interval95[0] < COMPLIANCE_N_per_mm < estimate.interval95[1]


@pytest.mark.slow
def test_a_compliance_asks_for_a_measurement_that_splits_its_class() -> None:
    following = with_compliance().diagnosis.next_measurement
    assert following is not None
    assert {"tangential_compliance", "displacement_load_coupling"} <= set(following["splits"])


@pytest.mark.slow
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
    diagnosis = concluded_of(record).diagnosis
    assert diagnosis.verdict == "explained"
    (angle,) = (c.parameters["angle_deg"] for c in diagnosis.causes if c.effect == "crossing_angle_error")
    assert angle.interval95[0] < 5.0 < angle.interval95[1]
    assert diagnosis.shrink.scar_held_out


@pytest.mark.slow
def test_whitened_residuals_of_gap_free_records_are_standard_deviates_at_most() -> None:
    """Solvers may differ by less than the covariance allows, never by more."""
    for seed in (2, 3, 4):
        one = independent_record(seed=seed)
        observed, setup = reduce(one), nominal_inputs(nominal_study(one), "sensor")
        covariance = estimate(frozen_states(), setup, observed)
        problem = Problem.of(frozen_states(), setup, observed.layout, covariance)
        whitened = problem.whitened(fit(problem, ()).setup)
        assert float((whitened**2).mean()) < 1.3
        assert abs(whitened).max() < 4.5


@pytest.mark.slow
def test_the_frozen_states_are_those_of_a_run_made_now() -> None:
    """Within what solvers may differ by; otherwise `python -m tests.exam.frozen_states` is due."""
    record = independent_record()
    observed, setup = reduce(record), nominal_inputs(nominal_study(record), "sensor")
    frozen, present = (
        observed.layout.observed(simulate(states, setup, observed.layout.cycles))
        for states in (frozen_states(), present_states(record))
    )
    covariance = estimate(frozen_states(), setup, observed)
    deviations = np.sqrt(np.diag(covariance.numerical + covariance.tolerated))
    assert (abs(present - frozen) / deviations).max() < 1.0


@pytest.mark.slow
def test_the_same_record_gives_the_same_answer_to_the_last_digit() -> None:
    again = concluded_of(independent_record(PLAY)).diagnosis
    assert json.dumps(again.to_json()) == json.dumps(with_play().diagnosis.to_json())


RADIUS_um, DEPTH_um = 225.0, 10.0
LINE_um = np.linspace(-160.0, 160.0, 161)


def test_noise_that_neighbours_share_counts_for_more() -> None:
    one = record(repeats=1, samples=400)
    random = np.random.default_rng(5)

    def coloured(size: int) -> Array:
        noise = np.zeros(size)
        for i, kick in enumerate(random.standard_normal(size)):
            noise[i] = 0.8 * noise[i - 1] + 0.6 * kick
        return noise

    loops = tuple(
        replace(loop, tangential_force_N=loop.tangential_force_N + 2.0 * NOISE_N * coloured(loop.time_s.size))
        for loop in one.loops
    )
    white, red = (reduce(replace(one, loops=own)) for own in (one.loops, loops))
    plain, shared = (float(np.nanmedian(own.noise[0, own.layout.of_kind(PlateauForce)])) for own in (white, red))
    # Independent noise of that size would raise the error by √5 = 2.24.
    assert shared > 2.5 * plain


def swept_scar(error_rad: float, reach_um: float) -> Array:
    """Depth on a wire along x after strokes of ±reach by one whose axis is off the right angle by that error."""
    x, y = np.meshgrid(LINE_um, LINE_um, indexing="ij")
    across = x * np.cos(error_rad) + y * np.sin(error_rad)
    past = np.maximum(np.abs(across) - reach_um, 0.0)
    depth: Array = np.maximum(DEPTH_um - (y**2 + past**2) / (2.0 * RADIUS_um), 0.0)
    return depth


@given(st.floats(-8.0, 8.0), st.floats(0.0, 60.0))
def test_the_skew_of_a_swept_scar_is_the_tangent_of_the_angle(error_deg: float, reach_um: float) -> None:
    error = np.radians(error_deg)
    skew = scar_skew(LINE_um, LINE_um, swept_scar(error, reach_um))
    assert skew == pytest.approx(-np.tan(error), abs=2e-3 + 0.03 * abs(error))


@pytest.mark.parametrize("noise", [0.02, 0.05])
def test_the_skew_of_a_noisy_shallow_scar_scatters_about_as_stated(noise: float) -> None:
    draws, scar = np.random.default_rng(1), swept_scar(0.05, 60.0)
    scar *= 1.0 / scar.max()
    maps = (scar + draws.normal(0.0, noise, scar.shape) for _ in range(100))
    found = np.array([skew_and_noise(LINE_um, LINE_um, own, noise) for own in maps])
    # Points that noise takes past the scar's edge are not part of it.
    assert 0.7 < found[:, 0].std() / found[:, 1].mean() < 2.0


def run_at(angle_deg: float) -> RunResult:
    """Its scars are bowls along the motion, without any skew, as no rigid sweep at such an angle leaves them."""
    wires = {"diameter_mm": 0.45, "youngs_modulus_MPa": 2.1e5, "poissons_ratio": 0.3, "crossing_angle_deg": angle_deg}
    asked = {"normal_load_N": 2.0, "displacement_amplitude_um": 60.0, "frequency_Hz": 3.0, "cycles": 100_000}
    study = {"format": 1, "name": "wires", "kind": "crossed-wires", "wires": wires, "conditions": asked}
    return replace(result(), study={**study, "contact": {"friction": 0.62}})


@pytest.mark.parametrize("angle_deg", [60.0, 75.0, 90.0])
def test_wires_at_the_stated_angle_have_the_skew_of_their_run_and_at_another_its_shear(angle_deg: float) -> None:
    own = WearStates.of_run(run_at(angle_deg))
    stated = np.radians(angle_deg - 90.0)
    skews = [
        simulate(own, replace(nominal(), crossing_error_rad=stated + more), np.array([CYCLES[-1]])).skew
        for more in (0.0, 0.05)
    ]
    assert skews[0] == pytest.approx(np.zeros(2), abs=1e-3)
    assert skews[1] == pytest.approx(np.full(2, np.tan(stated) - np.tan(stated + 0.05)), abs=1e-3)


def test_scars_at_the_end_are_those_of_the_run_although_its_last_loop_is_of_other_conditions() -> None:
    run = run_at(75.0)
    loops = tuple(loop(cycle, 500.0) for cycle in CYCLES)
    setup = replace(nominal(), crossing_error_rad=np.radians(-15.0))
    whole, cut = (
        simulate(WearStates.of_run(replace(run, loops=kept)), setup, np.array([CYCLES[-1]]))
        for kept in (loops, loops[:-1])
    )
    assert whole.scars[:, 1].min() > 1.0
    assert cut.scars == pytest.approx(whole.scars, rel=0.05)
    assert cut.skew == pytest.approx(whole.skew, abs=1e-3)


@pytest.mark.slow
def test_a_record_that_states_no_friction_and_wear_is_diagnosed_by_its_own_data() -> None:
    """The answer is that of the record which states both as they are."""
    stating = read_record(EXAMPLES / "rigid_stated_compliant_rig")
    silent = stating.tables.stated.model_copy(update={"friction": None, "energy_wear_coefficient_mm3_per_J": None})
    answer = diagnose(replace(stating, tables=stating.tables.model_copy(update={"stated": silent}))).diagnosis
    assert any(note.startswith("[stated] gives no friction and wear") for note in answer.notes)
    spring = next(cause for cause in answer.causes if cause.effect == "tangential_compliance")
    assert spring.parameters["stiffness_N_per_mm"].value == pytest.approx(167.0, rel=0.08)
