"""A late force, a viscous loop, a drifting displacement and a contact that sticks are noted with their sizes."""

import numpy as np
import pytest

from tests.diagnosis_cases import autoregressive
from tests.synthetic_loops import Recipe, SyntheticLoop, disturbed
from wirewear.loops import analyse_loop
from wirewear.loops.cleaning import clean_loop
from wirewear.loops.clipping import rounding_noise, step_of
from wirewear.loops.correlated_noise import correlated_noise
from wirewear.loops.drive import period_of
from wirewear.loops.robust import Array
from wirewear.loops.timing import lag_of

STEP, SIZE, CORRELATION = 0.01, 0.0075, 0.7

LOOP = SyntheticLoop(Recipe())


def channel(samples: int = 400) -> np.ndarray:
    time = np.arange(samples) / samples
    return np.asarray(
        np.sin(2.0 * np.pi * time) + SIZE * autoregressive(samples, CORRELATION, np.random.default_rng(3))
    )


def test_the_step_of_a_rounded_channel_is_found() -> None:
    rounded = STEP * np.round(channel() / STEP)
    assert step_of(rounded) == pytest.approx(STEP)
    assert step_of(0.3 + rounded) == pytest.approx(STEP)
    assert step_of(np.round(rounded, 6)) == pytest.approx(STEP)


def test_rounding_hides_no_correlation_of_the_noise_below_it() -> None:
    """As one autoregression, both would make means of many samples look surer than they are."""
    random = np.random.default_rng(8)
    design: Array = np.asarray(np.polynomial.chebyshev.chebvander(np.linspace(-1.0, 1.0, 160), 6), dtype=np.float64)
    alone: list[float] = []
    beside: list[float] = []
    for _ in range(30):
        noisy = 0.05 * design[:, 1] + 0.02 * design[:, 3] + SIZE * autoregressive(160, CORRELATION, random)
        parts = [(design, STEP * np.round(noisy / STEP))]
        for found, rounding in ((alone, 0.0), (beside, rounding_noise(STEP))):
            deviation, stretch = correlated_noise(parts, None, rounding)
            found.append(deviation * stretch)
    # A mean's error goes with the spectrum at frequency zero.
    expected = np.hypot(SIZE * np.sqrt((1.0 + CORRELATION) / (1.0 - CORRELATION)), rounding_noise(STEP))
    assert np.median(beside) == pytest.approx(expected, rel=0.15)
    assert np.median(alone) < np.median(beside)


@pytest.mark.parametrize("samples", [64, 128, 256])
@pytest.mark.parametrize("lag", [3, 5])
@pytest.mark.parametrize("noise", [0.0, 0.005])
def test_a_late_force_is_noted_and_read_as_much_earlier(samples: int, lag: int, noise: float) -> None:
    time, displacement, force = LOOP.sampled(samples, 0.3)
    displacement, force = disturbed(displacement, np.roll(force, lag), 2, noise, 0.0)
    figures = analyse_loop(displacement, force, 2.0, time_s=time)
    assert any("samples late" in note for note in figures.notes)
    assert figures.dissipated_energy_mJ.value == pytest.approx(LOOP.energy_mJ, rel=0.02)
    for figure, truth in (
        (figures.dissipated_energy_mJ, LOOP.energy_mJ),
        (figures.slip_amplitude_um, LOOP.slip_amplitude_um),
    ):
        assert figure.interval95[0] <= truth <= figure.interval95[1]


@pytest.mark.parametrize(("samples", "noise"), [(64, 0.0), (128, 0.0), (256, 0.0), (64, 0.005), (128, 0.005)])
def test_a_late_displacement_is_noted_and_the_interval_holds_the_truth(samples: int, noise: float) -> None:
    time, displacement, force = LOOP.sampled(samples, 0.3)
    displacement, force = disturbed(displacement, np.roll(force, -3), 2, noise, 0.0)
    figures = analyse_loop(displacement, force, 2.0, time_s=time)
    assert any("before the reversals" in note for note in figures.notes)
    for figure, truth in (
        (figures.dissipated_energy_mJ, LOOP.energy_mJ),
        (figures.slip_amplitude_um, LOOP.slip_amplitude_um),
    ):
        assert figure.interval95[0] <= truth <= figure.interval95[1]


@pytest.mark.parametrize("lag", [-5.0, -2.0, 0.0, 1.0, 4.0])
@pytest.mark.parametrize("share", [0.0, 1.0], ids=["spring", "Mindlin"])
def test_a_lag_is_told_whatever_of_spring_or_contact_takes_up_the_rise(lag: float, share: float) -> None:
    stiff = {"contact_stiffness": 1e6} if share == 0.0 else {"contact_stiffness": 160.0, "rig_stiffness": 1e9}
    time, displacement, force = SyntheticLoop(Recipe(**stiff)).sampled(2560, 0.31)
    found = lag_of(clean_loop(displacement[::10], np.roll(force, round(10 * lag))[::10], time_s=time[::10]))
    assert found is not None
    assert found.interval95[0] <= lag <= found.interval95[1]
    assert found.deviation < 0.8


@pytest.mark.parametrize("noise", [0.0, 0.002])
def test_a_viscous_ellipse_is_noted_and_has_no_figures_of_sliding(noise: float) -> None:
    phase = 2.0 * np.pi * np.arange(256) / 256
    displacement, force = disturbed(350.0 * np.sin(phase), 1.19 * np.cos(phase), 1, noise, 0.0)
    figures = analyse_loop(displacement, force, 2.0)
    assert any("ellipse" in note for note in figures.notes)
    assert figures.friction_energy is None
    assert figures.friction_geometry_independent is None


@pytest.mark.parametrize("noise", [0.0, 0.003])
@pytest.mark.parametrize("drift", [-0.05, 0.05])
@pytest.mark.parametrize("start", [0.1, 0.4])
def test_a_displacement_that_drifts_within_the_loop_is_noted_and_freed_from_it(
    noise: float, drift: float, start: float
) -> None:
    time, displacement, force = LOOP.sampled(256, start)
    displacement, force = disturbed(displacement, force, 3, noise, 0.0)
    figures = analyse_loop(displacement + drift * 120.0 * time, force, 2.0, time_s=time)
    assert any("drifts by" in note for note in figures.notes)
    assert figures.dissipated_energy_mJ.value == pytest.approx(LOOP.energy_mJ, rel=0.01)
    assert figures.slip_amplitude_um.value == pytest.approx(LOOP.slip_amplitude_um, rel=0.01)


@pytest.mark.parametrize("noise", [0.0, 0.005])
def test_a_contact_that_sticks_says_so_with_its_numbers(noise: float) -> None:
    phase = 2.0 * np.pi * np.arange(200) / 200
    displacement, force = disturbed(6.0 * np.sin(phase), 0.9 * np.sin(phase), 4, noise, 0.0)
    figures = analyse_loop(displacement, force, 2.0)
    assert figures.slip_amplitude_um.value >= 0.0
    assert any("sticks" in note and "N/mm" in note and "6 µm" in note for note in figures.notes) or noise
    assert any("sticks" in note for note in figures.notes)


@pytest.mark.parametrize("last", [0.5, 1.0, 3.0])
@pytest.mark.parametrize("start", [0.0, 0.25, 0.6])
def test_a_cycles_period_is_told_by_its_drive_where_steps_are_uneven(start: float, last: float) -> None:
    """Whatever the last step is: the mean of the others, or their median, miss it by up to 4 % of the period."""
    random = np.random.default_rng(1)
    steps = np.append(random.uniform(0.3, 2.0, 63), last)
    time = np.cumsum(steps)[:-1] / steps.sum()
    displacement = 60.0 * np.sin(2.0 * np.pi * (time + start)) + 0.15 * random.standard_normal(time.size)
    assert period_of(time, displacement) == pytest.approx(1.0, abs=1e-3)
