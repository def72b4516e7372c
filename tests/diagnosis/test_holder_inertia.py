"""A holder's mass on its springs under Coulomb friction that changes sign at each reversal, by Den Hartog (1931)."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from geometry.arrays import Array
from tests.diagnosis.diagnosis_cases import with_effect
from tests.diagnosis.test_sticking_diagnosis import FRICTION_N, ball, circumstances
from tests.simulation.point_contacts import STEEL, TEST
from wirewear.diagnosis.surrogate.forward import simulate
from wirewear.loops.sensor import DAMPING, LoopSignals, Sensor
from wirewear.results.values import sensor_of
from wirewear.test import study_from_tables

FREQUENCY_Hz, COMPLIANCE_um_per_N = 40.0, 0.5


def den_hartog(angle: Array, ratio: float) -> Array:
    """Force of the spring over the friction of one sign, at angles from 0 to π after its reversal.

    ratio: the drive's frequency over the holder's own. Half a cycle later everything has the other sign.
    """
    motion = np.array([[0.0, 1.0], [-1.0 / ratio**2, -2.0 * DAMPING / ratio]])
    rest, half, one = np.array([1.0, 0.0]), expm(np.pi * motion), np.eye(2)
    start = np.linalg.solve(half + one, (half - one) @ rest)
    return np.array([(rest + expm(motion * at) @ (start - rest))[0] for at in angle])


def mass_kg(ratio: float) -> float:
    return 1e6 * ratio**2 / (COMPLIANCE_um_per_N * (2.0 * np.pi * FREQUENCY_Hz) ** 2)


def test_without_damping_the_closed_form_is_den_hartogs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(globals(), "DAMPING", 0.0)
    angle, ratio = np.linspace(0.0, np.pi, 9), 0.15
    expected = 1.0 - np.cos((angle - 0.5 * np.pi) / ratio) / np.cos(0.5 * np.pi / ratio)
    assert den_hartog(angle, ratio) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("ratio", [0.06, 0.15, 0.3])
def test_the_force_cell_of_a_swinging_holder_reads_as_den_hartog_says(ratio: float) -> None:
    count = 4096
    angle = 2.0 * np.pi * (np.arange(count) + 0.5) / count
    friction, time = np.where(angle < np.pi, 1.0, -1.0), angle / (2.0 * np.pi * FREQUENCY_Hz)
    truth = LoopSignals(time, np.cos(angle), friction)
    sensor = Sensor(swing_s2=(ratio / (2.0 * np.pi * FREQUENCY_Hz)) ** 2)
    read = sensor.read(truth)
    assert read.tangential_force_N[: count // 2] == pytest.approx(den_hartog(angle[: count // 2], ratio), abs=0.005)
    assert sensor.corrected(read).tangential_force_N == pytest.approx(friction, abs=1e-6)


@pytest.mark.parametrize("ratio", [0.06, 0.15, 0.3])
def test_loops_of_the_fast_model_ring_as_den_hartog_says(ratio: float) -> None:
    """The stroke is so long that contact and springs take none of it."""
    stroke_um = 1e5
    test = replace(circumstances(stroke_um, compliance_um_per_N=COMPLIANCE_um_per_N), frequency_Hz=FREQUENCY_Hz)
    course = simulate(ball(), with_effect(test, "holder_inertia", {"mass_kg": mass_kg(ratio)}), np.array([1.0]))
    x, q = course.displacement_um[0, 0], course.tangential_force_N[0, 0]
    angle = np.arccos(np.clip(-x / stroke_um, -1.0, 1.0))
    own = (angle > 0.1) & (angle < np.pi - 0.05)
    assert np.count_nonzero(own) > 20
    assert q[own] / FRICTION_N == pytest.approx(den_hartog(angle[own], ratio), abs=0.15)


def test_a_run_of_a_ball_is_read_by_a_force_cell_whose_holder_swings() -> None:
    bodies = {"ball": {"diameter_mm": 12.7, **STEEL}, "flat": STEEL}
    swings = [{"name": "holder_inertia", "mass_kg": 3.2}]
    study = study_from_tables(
        TEST | {"kind": "ball-on-flat", "bodies": bodies, "holder": {"tangential_stiffness_N_per_mm": 5000.0}}
        | {"effects": swings}, "s"
    )  # fmt: skip
    assert sensor_of(study.resolved()).swing_s2 == pytest.approx(3.2 / 5e6)
