"""Calibration of a remote sensor: simulated motions under load, the polynomial, and records corrected with it."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from tests.synthetic_results import result
from tests.test_simulate import COARSE
from wirewear import check_record, read_record, record_of_result, write_record
from wirewear.fitting.sensor_calibration import Calibration, LoadedMotion, LoadPolynomial, calibrate, fitted_polynomial
from wirewear.fitting.sensor_correcting import corrected_record
from wirewear.loops import Measured, Sensor, SensorNoise
from wirewear.reference import Elastic, contact_modulus, hertz_point, mindlin_stiffness, tangential_contact_modulus
from wirewear.results import RunResult
from wirewear.study import Study, load_study, parse_study

ROOT = Path(__file__).parent.parent
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
def test_a_record_read_through_a_known_polynomial_is_corrected_to_within_its_noise(
    run: RunResult, tmp_path: Path
) -> None:
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
    reread = read_record(write_record(tmp_path, corrected.record))
    assert not check_record(reread).problems


def study(text: str = COARSE) -> Study:
    return parse_study(text.replace("= 9.0", "= 6.0"), "the test's study")


@pytest.fixture(scope="module")
def wires() -> Calibration:
    return calibrate(study(), normal_loads_N=[2.0], fidelity="quick", remote_compliance_um_per_N=0.3)


@pytest.mark.slow
def test_the_moving_wires_compliance_is_half_of_mindlins_and_the_stated_one_comes_on_top(wires: Calibration) -> None:
    """Two alike wires share Mindlin's 1/(2G*a); the gripped wire is no half-space and adds some per cent."""
    steel = Elastic(210000.0, 0.3)
    radius = hertz_point(2.0, 0.225, contact_modulus(steel, steel)).contact_radius_mm
    contact = mindlin_stiffness(tangential_contact_modulus(steel, steel), radius)
    assert wires.polynomial.linear_um_per_N.value - 0.3 == pytest.approx(0.5e3 / contact, rel=0.15)
    assert abs(wires.polynomial.quadratic_um_per_N2.value) < 1e-3
    np.testing.assert_allclose(wires.motions[0].tangential_force_N.max(), 0.62 * 2.0, rtol=0.02)


@pytest.mark.slow
def test_between_the_holders_lies_the_rigs_compliance(wires: Calibration) -> None:
    found = calibrate(study(), normal_loads_N=[2.0], near="between-holders", fidelity="quick").polynomial
    assert found.linear_um_per_N.value == pytest.approx(1e3 / 167.0, rel=1e-6)
    assert abs(found.quadratic_um_per_N2.value) < 1e-6


@pytest.mark.slow
def test_between_sticking_wires_nothing_moves_so_all_compliance_is_found(wires: Calibration) -> None:
    found = calibrate(study(), normal_loads_N=[2.0], near="between-wires", fidelity="quick")
    near, remote = found.motions[0].near_um, found.motions[0].remote_um
    assert np.abs(near).max() < 0.02 * np.abs(remote).max()
    one_wire = wires.polynomial.linear_um_per_N.value - 0.3
    assert found.polynomial.linear_um_per_N.value == pytest.approx(1e3 / 167.0 + 2.0 * one_wire, rel=0.01)
