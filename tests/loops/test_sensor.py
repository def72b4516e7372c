"""The sensor model: closed forms of what it does to a loop, what can be undone; calibrations of a remote sensor."""

import dataclasses
import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.bodies import crossed_wires
from tests.simulation.coarse_runs import COARSE
from tests.synthetic_loops import Recipe, SyntheticLoop
from tests.synthetic_results import result
from wirewear import check_record, read_record, record_of_result, write_record
from wirewear.diagnosis.fit.sensor_calibration import (
    Calibration,
    LoadedMotion,
    LoadPolynomial,
    _loaded,
    calibrate,
    corrected_record,
    fitted_polynomial,
)
from wirewear.loops import LoopSignals, Measured, Sensor, SensorNoise, analyse_loop
from wirewear.loops.held_stroke import sensor_held_stroke
from wirewear.reference import Elastic, contact_modulus, hertz_point, mindlin_stiffness, tangential_contact_modulus
from wirewear.results import RunResult
from wirewear.test import Study, load_study, parse_study

FREQUENCY_Hz = 3.0


@cache
def wire_loop(samples: int = 256, recipe: Recipe | None = None, frequency_Hz: float = FREQUENCY_Hz) -> LoopSignals:
    """A loop behind a rig spring with hooks at its ends and a ripple of the load."""
    loop = SyntheticLoop(recipe or Recipe(end_slope_rad=0.1, hook_power=3.0))
    time, displacement, force = loop.sampled(samples)
    load = loop.recipe.normal_load_N * (1.0 + 0.05 * np.sin(4.0 * math.pi * time))
    return LoopSignals(time / frequency_Hz, displacement, force, load)


def area_mJ(signals: LoopSignals) -> float:
    """∮Q dδ by the trapezoid rule."""
    x, q = 1e-3 * signals.displacement_um, signals.tangential_force_N
    return float(np.sum(0.5 * (q + np.roll(q, -1)) * (np.roll(x, -1) - x)))


def assert_same(left: LoopSignals, right: LoopSignals, within: float) -> None:
    for name in ("displacement_um", "tangential_force_N", "normal_force_N"):
        expected = getattr(right, name)
        np.testing.assert_allclose(getattr(left, name), expected, atol=within * np.abs(expected).max(), rtol=0.0)


@given(st.floats(-2.0, 2.0), st.floats(-1.0, 1.0), st.floats(0.0, 2.0))
@settings(deadline=None, max_examples=40)
def test_a_load_coupled_reading_leaves_the_energy_of_the_loop(linear: float, quadratic: float, remote: float) -> None:
    truth = wire_loop(1024)
    read = Sensor(linear_um_per_N=linear, quadratic_um_per_N2=quadratic, remote_compliance_um_per_N=remote).read(truth)
    assert area_mJ(read) == pytest.approx(area_mJ(truth), rel=1e-3)


def test_a_remote_point_softens_the_measured_stiffness_in_series() -> None:
    truth = wire_loop(512)
    read = Sensor(remote_compliance_um_per_N=2.0).read(truth)
    true, apparent = (
        analyse_loop(loop.displacement_um, loop.tangential_force_N, 2.0).measured_stiffness_N_per_um
        for loop in (truth, read)
    )
    assert true is not None
    assert apparent is not None
    assert 1.0 / apparent.value == pytest.approx(1.0 / true.value + 2.0, rel=0.01)


def test_crosstalk_offsets_the_force_by_the_load_and_ripples_the_load_by_the_force() -> None:
    truth = wire_loop()
    assert truth.normal_force_N is not None
    read = Sensor(force_crosstalk=0.03).read(truth)
    assert read.normal_force_N is not None
    np.testing.assert_allclose(read.tangential_force_N - truth.tangential_force_N, 0.03 * truth.normal_force_N)
    np.testing.assert_allclose(read.normal_force_N - truth.normal_force_N, 0.03 * truth.tangential_force_N)


def elastic_loop(frequency_Hz: float, samples: int = 128, stiffness_N_per_um: float = 0.1) -> LoopSignals:
    time = np.arange(samples) / samples / frequency_Hz
    displacement = 10.0 * np.sin(2.0 * math.pi * frequency_Hz * time + 0.3)
    return LoopSignals(time, displacement, stiffness_N_per_um * displacement)


@pytest.mark.parametrize("frequency_Hz", [1.0, 3.0, 10.0])
def test_a_delay_gives_an_elastic_loop_the_area_of_its_phase(frequency_Hz: float) -> None:
    """∮Q dδ = πKa² sin ωτ for Q = Kδ read τ late; Fourier interpolation of a sine is exact, the polygon is not."""
    read = Sensor(lag_s=1e-3, lag_kind="delay").read(elastic_loop(frequency_Hz, 1024))
    expected = math.pi * 0.1 * 10.0**2 * math.sin(2.0 * math.pi * frequency_Hz * 1e-3) * 1e-3
    assert area_mJ(read) == pytest.approx(expected, rel=1e-4)


def test_a_first_order_lag_reads_a_sine_smaller_and_late() -> None:
    truth = elastic_loop(3.0)
    read = Sensor(lag_s=5e-3).read(truth)
    angle = 2.0 * math.pi * 3.0 * 5e-3
    late = 10.0 * np.sin(2.0 * math.pi * 3.0 * truth.time_s + 0.3 - math.atan(angle)) / math.hypot(1.0, angle)
    np.testing.assert_allclose(read.displacement_um, late, atol=1e-12)


SENSORS = st.builds(
    Sensor, remote_compliance_um_per_N=st.floats(0.0, 3.0), displacement_gain=st.floats(0.5, 2.0),
    linear_um_per_N=st.floats(-2.0, 2.0), quadratic_um_per_N2=st.floats(-1.0, 1.0),
    tangential_force_gain=st.floats(0.5, 2.0), normal_force_gain=st.floats(0.5, 2.0),
    force_crosstalk=st.floats(-0.5, 0.5), lag_s=st.floats(0.0, 5e-3),
    lag_kind=st.sampled_from(["first-order", "delay"]),
)  # fmt: skip


@given(SENSORS, st.sampled_from([64, 65, 256]))
@settings(deadline=None, max_examples=60)
def test_correcting_a_noise_free_reading_gives_back_the_truth(sensor: Sensor, samples: int) -> None:
    truth = wire_loop(samples)
    assert_same(sensor.corrected(sensor.read(truth)), truth, 1e-10)


@pytest.mark.parametrize("correlation", [0.0, 0.8])
def test_noise_has_its_deviation_and_memory_and_repeats_with_its_seed(correlation: float) -> None:
    noise = SensorNoise(0.2, 0.01, 0.02, correlation)
    truth = LoopSignals(np.arange(20000.0), *np.zeros((3, 20000)))
    first, again = (Sensor(noise=noise).read(truth, np.random.default_rng(4)) for _ in range(2))
    error = first.displacement_um
    np.testing.assert_array_equal(error, again.displacement_um)
    assert np.std(error) == pytest.approx(0.2, rel=0.05)
    assert np.corrcoef(error[1:], error[:-1])[0, 1] == pytest.approx(correlation, abs=0.03)
    assert np.std(first.tangential_force_N) == pytest.approx(0.01, rel=0.05)
    assert first.normal_force_N is not None
    assert np.std(first.normal_force_N) == pytest.approx(0.02, rel=0.05)


def stick_or_slide(amplitude_um: float, stiffness: float = 0.5) -> LoopSignals:
    """Sticks up to 2 µm behind 0.5 N/µm, slides with 1 N beyond."""
    phase = 2.0 * math.pi * np.arange(256) / 256
    force = np.clip(stiffness * amplitude_um * np.sin(phase), -1.0, 1.0)
    return LoopSignals(phase, amplitude_um * np.sin(phase), force)


@given(st.floats(0.5, 80.0), st.floats(-0.5, 3.0), st.floats(0.8, 1.2))
@settings(deadline=None, max_examples=60)
def test_the_stroke_behind_a_sensor_held_amplitude_is_read_as_asked(asked: float, linear: float, gain: float) -> None:
    sensor = Sensor(displacement_gain=gain, linear_um_per_N=linear)
    held = sensor_held_stroke(sensor, asked, stick_or_slide, most_evaluations=12)
    assert sensor.read(stick_or_slide(held.amplitude_um)).displacement_amplitude_um == pytest.approx(asked, rel=1e-6)


ROOT = Path(__file__).parents[2]
SENSOR = Sensor(linear_um_per_N=0.8, quadratic_um_per_N2=-0.15)
EXACT = LoadPolynomial(Measured(0.8, (0.79, 0.81)), Measured(-0.15, (-0.16, -0.14)), 2.0, 0.01, 0.02)


def motion(load_N: float, noise_um: float = 0.0, seed: int = 0) -> LoadedMotion:
    force = np.linspace(-0.6, 0.6, 9) * load_N
    near = 3.0 * force
    noise = noise_um * np.random.default_rng(seed).standard_normal(9)
    return LoadedMotion(load_N, force, near + 0.8 * force - 0.15 * force**2 + noise, near)


def test_the_polynomials_intervals_hold_the_truth_as_often_as_they_promise() -> None:
    fits = [fitted_polynomial([motion(1.0, 0.05, seed), motion(3.0, 0.05, 1000 + seed)]) for seed in range(200)]
    for name, truth in (("linear_um_per_N", 0.8), ("quadratic_um_per_N2", -0.15)):
        intervals = [getattr(fit, name).interval95 for fit in fits]
        assert 0.9 < np.mean([low <= truth <= high for low, high in intervals]) < 0.99


@pytest.fixture(scope="module")
def run() -> RunResult:
    study = load_study(ROOT / "studies" / "steel_wires" / "study.toml")
    return dataclasses.replace(result("", 167.0), study=study.variant("compliant").resolved())


@pytest.mark.seconds
def test_a_record_read_through_a_known_polynomial_is_corrected_within_noise(run: RunResult, tmp_path: Path) -> None:
    """The force's noise, 0.008 N, adds 0.8 × 0.008 µm; a slope of 1 − 2·0.15·Q/0.8 lets it vary by half."""
    noise = SensorNoise(displacement_um=0.15, tangential_force_N=0.008, normal_force_N=0.01)
    coupled = dataclasses.replace(SENSOR, noise=noise)
    read, ideal = (
        record_of_result(run, sensor=sensor, repeats=2, seed=3, samples=256)
        for sensor in (coupled, Sensor(noise=noise))
    )
    corrected = corrected_record(read, EXACT)
    for before, after, truth in zip(read.loops, corrected.record.loops, ideal.loops, strict=True):
        left = after.displacement_um - truth.displacement_um
        assert np.abs(before.displacement_um - truth.displacement_um).max() > 0.7
        assert np.std(left) < 1.5 * 0.8 * 0.008
        np.testing.assert_array_equal(after.tangential_force_N, truth.tangential_force_N)
    assert corrected.noise_um == pytest.approx(0.0064)
    assert corrected.record.tables.noise.displacement_um == pytest.approx(np.hypot(0.15, 0.0064))
    assert corrected.error_um == pytest.approx(
        np.hypot(0.01 * corrected.largest_force_N, 0.01 * corrected.largest_force_N**2)
    )
    assert corrected.notes == ()
    assert not check_record(read_record(write_record(tmp_path, corrected.record))).problems


def study(text: str = COARSE) -> Study:
    return parse_study(text.replace("= 9.0", "= 6.0"), "the test's study")


@pytest.fixture(scope="module")
def wires() -> Calibration:
    return calibrate(study(), normal_loads_N=[2.0], fidelity="quick", remote_compliance_um_per_N=0.3)


@pytest.mark.slow
def test_a_wires_compliance_is_half_of_mindlins_and_between_the_holders_lies_the_rigs(wires: Calibration) -> None:
    """Two alike wires share Mindlin's 1/(2G*a); the gripped wire is no half-space and adds some per cent."""
    steel = Elastic(210000.0, 0.3)
    radius = hertz_point(2.0, 0.225, contact_modulus(steel, steel)).contact_radius_mm
    contact = mindlin_stiffness(tangential_contact_modulus(steel, steel), radius)
    assert wires.polynomial.linear_um_per_N.value - 0.3 == pytest.approx(0.5e3 / contact, rel=0.15)
    assert abs(wires.polynomial.quadratic_um_per_N2.value) < 1e-3
    np.testing.assert_allclose(wires.motions[0].tangential_force_N.max(), 0.62 * 2.0, rtol=0.02)
    found = calibrate(study(), normal_loads_N=[2.0], near="between-holders", fidelity="quick").polynomial
    assert found.linear_um_per_N.value == pytest.approx(1e3 / 167.0, rel=1e-6)
    assert abs(found.quadratic_um_per_N2.value) < 1e-6


@pytest.mark.parametrize("primary_is_upper", [True, False])
def test_wires_that_stick_to_each_other_move_as_one(*, primary_is_upper: bool) -> None:
    problem = crossed_wires(0.01, long_patch=True, friction=20.0, primary_is_upper=primary_is_upper)
    found = _loaded(problem, 2.0, 1.24, "between-wires", 0.0)
    assert np.abs(found.near_um).max() < 0.002 * np.abs(found.remote_um).max()
