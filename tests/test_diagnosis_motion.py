"""How a drive passes its stroke is told from the displacement over time, and decides what a lag does to a loop."""

import numpy as np
import pytest

from tests.diagnosis_cases import NOISE_um, nominal, record
from wirewear.diagnosis.model.motion import SINE, FastMotion
from wirewear.diagnosis.model.readings import late_places
from wirewear.diagnosis.model.setup import Array
from wirewear.diagnosis.observe.motion_of_loops import harmonics_of, motion_of
from wirewear.diagnosis.observe.reduction import reduce

LAG = 0.03


def triangle(phase: Array) -> Array:
    return np.asarray(2.0 / np.pi * np.arcsin(np.sin(phase)))


def told(shape: Array, noise: float, loops: int = 24) -> FastMotion:
    """The motion told from loops of one cycle each, which begin anywhere."""
    random, samples = np.random.default_rng(4), shape.size
    time = np.arange(samples) / samples
    found = []
    for _ in range(loops):
        noisy = np.roll(shape, int(random.integers(samples))) + noise * random.standard_normal(samples)
        found.append(harmonics_of(time, 1.0, noisy))
    return motion_of(found, noise * float(np.sqrt(2.0 / (samples - 2.0 * found[0].size - 1.0))))


def branches() -> Array:
    """Places of both branches (1, 2, m)."""
    there = np.sin(0.5 * np.pi * np.linspace(-1.0, 1.0, 41))
    return np.stack([there, -there])[None]


def phases(samples: int = 400) -> Array:
    return np.asarray(2.0 * np.pi * np.arange(samples) / samples)


def test_noise_does_not_make_a_sine_another_motion() -> None:
    assert told(np.sin(phases()), 0.003).harmonics.size == 1
    assert reduce(record(repeats=2)).motion.harmonics.size == 1


def test_harmonics_of_an_eccentric_are_found() -> None:
    shape = np.sin(phases()) + 0.02 * np.sin(2.0 * phases()) - 0.01 * np.sin(3.0 * phases())
    found = told(shape, 0.003).harmonics
    assert found == pytest.approx(np.array([-1j, -0.02j, 0.01j]), abs=6e-4)


def test_a_sines_lag_turns_its_phase() -> None:
    place, turn = branches(), np.arctan(LAG)
    expected = np.sin(np.stack([np.arcsin(place[0, 0]), np.pi - np.arcsin(place[0, 1])]) - turn)
    held = late_places(nominal("sensor"), place, LAG)
    assert held[0] == pytest.approx(expected, abs=1e-4)
    assert late_places(nominal("stroke"), place, LAG)[0] == pytest.approx(np.cos(turn) * expected, abs=1e-4)
    assert SINE.phases(place)[0, 0] == pytest.approx(2.0 * np.pi + np.arcsin(place[0, 0]), abs=1e-9)


def test_a_triangles_lag_is_told_from_what_the_late_sensor_reads() -> None:
    """In closed form: x less v τ (1 − 2 exp(−t/τ)) at times t after a reversal; its stroke shrinks by v τ ln 2."""
    spectrum = np.fft.rfft(triangle(phases(4096)))
    late = np.fft.irfft(spectrum / (1.0 + 1j * LAG * np.arange(spectrum.size)), 4096)
    motion = told(np.interp(phases(), phases(4096), late), 0.002)
    before = motion.before(LAG)
    after = before.behind(LAG)
    place, speed = branches(), 2.0 / np.pi
    since = 0.5 * np.pi * (place[0, 0] + 1.0)
    change = (after.at(before.phases(place)) - before.at(before.phases(place))) / before.half_range
    assert change[0, 0] == pytest.approx(-speed * LAG * (1.0 - 2.0 * np.exp(-since / LAG)), abs=2.5e-3)
    assert after.half_range / before.half_range == pytest.approx(1.0 - speed * LAG * np.log(2.0), abs=1e-3)


def test_the_middle_of_a_loop_is_as_unsure_as_its_tips() -> None:
    observed = reduce(record(repeats=1, samples=400))
    assert 0.0 < observed.centre_error_um < 0.3 * NOISE_um
