"""Loops however they are sampled, turned or disturbed: measured all the same, or refused in one sentence."""

import contextlib
import math
from itertools import permutations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from geometry.arrays import Array
from tests.diagnosis.diagnosis_cases import autoregressive
from tests.synthetic_loops import HOOKED, Recipe, SyntheticLoop, assert_known, disturbed, hooked, share_off
from wirewear.base.errors import WirewearError
from wirewear.loops import LoopError, analyse_loop
from wirewear.loops.cleaning import _readings, clean_loop
from wirewear.loops.cycles import continues_a_line
from wirewear.loops.drive import Drift, drift_of, period_of
from wirewear.loops.lag import is_certain, lag_of
from wirewear.loops.noise import correlated_noise, rounding_noise, step_of
from wirewear.loops.outline import shortened, step_lengths


@pytest.mark.parametrize(("displacement_sign", "force_sign", "step"), [(1, -1, 1), (-1, 1, 1), (-1, -1, 1), (1, 1, -1)])
def test_sign_and_direction_conventions_do_not_matter(displacement_sign: int, force_sign: int, step: int) -> None:
    displacement, force = hooked()
    figures = analyse_loop(displacement_sign * displacement[::step], force_sign * force[::step], 2.0)
    assert_known(figures)
    turned = any("reversed" in note or "sign was changed" in note for note in figures.notes)
    assert turned == (displacement_sign * force_sign * step < 0)


@pytest.mark.parametrize(
    ("displaced", "forced"),
    [((1.0, 0), (4.0, 0)), ((3.0, 0), (1.0, 0)), ((1.0, 0), (2.5, 0)), ((1.0, 0), (8.0, 3)), ((2.0, 0), (2.0, 1))],
)
def test_of_readings_that_a_logger_keeps_only_the_first_count(
    displaced: tuple[float, int], forced: tuple[float, int]
) -> None:
    """For how many samples each channel is kept, and from which on; read as they stand, a stiffness was 11 % off."""
    rng, count = np.random.default_rng(3), np.arange(1, 401)
    displacement, force = -60.0 * np.cos(2.0 * np.pi * count / 200.0), np.full(400, -1.2)
    for k in range(1, 400):
        force[k] = np.clip(force[k - 1] + 0.167 * (displacement[k] - displacement[k - 1]), -1.2, 1.2)

    def kept(values: Array, samples: float, first: int) -> Array:
        at = first + np.floor(np.floor((np.arange(400) - first) / samples) * samples).astype(int)
        return np.asarray(values[np.maximum(at, 0)])

    displacement = kept(displacement + 0.05 * rng.normal(size=400), *displaced)
    force = kept(force + 3e-3 * rng.normal(size=400), *forced)
    figures = analyse_loop(displacement[100:300], force[100:300], 2.0)
    stiffness = figures.measured_stiffness_N_per_um
    assert stiffness is not None
    assert figures.friction_energy is not None
    assert stiffness.value == pytest.approx(0.167, rel=0.03)
    assert figures.dissipated_energy_mJ.value == pytest.approx(0.2535, rel=0.01)
    assert figures.friction_energy.value == pytest.approx(0.6, rel=0.01)
    assert sum("keeps each reading" in note for note in figures.notes) == 1
    assert not any("late" in note or "outlying" in note for note in figures.notes)


def test_steps_of_a_converter_and_a_drive_that_rests_are_not_kept_readings() -> None:
    displacement = np.asarray(60.0 * np.sin(2.0 * np.pi * np.arange(200) / 200.0), dtype=np.float64)
    force = np.asarray(np.arange(200) // 50, dtype=np.float64)
    assert _readings(np.round(displacement / 5.0) * 5.0) is None
    assert _readings(np.round(np.abs(np.arange(200) - 100.0) / 4.0)) is None
    assert _readings(np.minimum(np.maximum(displacement, -50.0), 50.0)) is None
    assert _readings(np.maximum(np.roll(displacement, -40), -10.0)) is None
    assert _readings(force) is None


@pytest.mark.parametrize("samples", [40, 200])
def test_a_square_loop_without_noise_is_measured(samples: int) -> None:
    """A force that jumps to its plateau passes no level above it, and reaches it with no step."""
    times = np.arange(samples) / samples
    displacement = 50.0 * (1.0 - 4.0 * np.abs(times - 0.5))
    force = np.where(times < 0.5, 1.4, -1.4)
    lag = lag_of(clean_loop(displacement, force, 2.0, time_s=times))
    assert lag is None or not is_certain(lag)
    energy = analyse_loop(displacement, force, 2.0, time_s=times).dissipated_energy_mJ
    assert energy.value == pytest.approx(0.28, rel=3.0 / samples)


@pytest.mark.parametrize(("cycles", "note"), [(0.96, "open by"), (1.04, "run on past one cycle"), (1.2, "past one")])
def test_a_loop_that_ends_early_or_late_is_noted_and_still_measured(cycles: float, note: str) -> None:
    times = np.arange(256) / 256 * cycles
    _, displacement, force = HOOKED.sampled(256, 0.1, times)
    figures = analyse_loop(*disturbed(displacement, force, 5, force_scale=1.24), 2.0, time_s=times)
    assert_known(figures)
    assert any(note in said for said in figures.notes)


@pytest.mark.parametrize("cycles", [1.4, 1.5, 1.75, 2.0, 3.0])
@pytest.mark.parametrize("start", [0.0, 0.1, 0.25, 0.5, 0.75])
def test_more_than_one_cycle_is_not_one_loop(cycles: float, start: float) -> None:
    times = np.arange(int(200 * cycles)) / 200
    _, displacement, force = HOOKED.sampled(200, start, times)
    with pytest.raises(LoopError, match=r"sweep the stroke \d times where one cycle was expected"):
        analyse_loop(displacement, force, 2.0, time_s=times)


@pytest.mark.parametrize("seed", range(2))
def test_a_triangular_drive_keeps_its_sharp_tips(seed: int) -> None:
    phase = np.arange(256) / 256
    quarter = np.arcsin(2.0 / math.pi * np.arcsin(np.sin(2.0 * math.pi * phase))) / (2.0 * math.pi)
    times = np.where(phase < 0.25, quarter, np.where(phase < 0.75, 0.5 - quarter, 1.0 + quarter))
    _, displacement, force = HOOKED.sampled(256, 0.0, times)
    assert_known(analyse_loop(*disturbed(displacement, force, seed, force_scale=1.24), 2.0, time_s=phase))


def test_outliers_near_each_other_do_not_hide_one_another() -> None:
    _, displacement, force = HOOKED.sampled(256, 0.1)
    displacement, force = disturbed(displacement, force, 12, outlier_share=0.0, force_scale=1.24)
    force[[40, 42]] -= 1.3
    force[[170, 172]] += [2.0, 4.0]
    figures = analyse_loop(displacement, force, 2.0)
    assert figures.outlier_samples == (40, 42, 170, 172)
    assert_known(figures)


def test_the_tip_of_a_stick_continues_its_samples_an_outlier_does_not() -> None:
    time = np.arange(20.0)
    for off, goes_on in ((0.0, True), (5.0, False)):
        force = np.where(time < 10.0, time, time - 9.5) + off * (time == 9.0)
        assert continues_a_line(time, force, 9, 0.0) is goes_on


def test_a_varying_normal_force_is_divided_out_sample_by_sample() -> None:
    time, displacement, force = HOOKED.sampled(256, 0.1)
    ripple = 1.0 + 0.1 * np.sin(4.0 * math.pi * time)
    figures = analyse_loop(displacement, force * ripple, 2.0 * ripple, time_s=time)
    assert share_off(figures.friction_geometry_independent, 0.62) < 0.01
    assert share_off(figures.friction_max, math.tan(math.atan(0.62) + 0.15)) < 0.02


@pytest.mark.seconds
@example(330, 16, "spikes")
@example(287, 16, "noise")  # one sample on a branch
@given(st.integers(0, 10**6), st.integers(16, 90), st.sampled_from(["noise", "steps", "elastic", "spikes"]))
@settings(deadline=None, max_examples=60)
def test_any_finite_samples_are_measured_or_refused_in_our_own_words(seed: int, samples: int, kind: str) -> None:
    random = np.random.default_rng(seed)
    phase = 2.0 * math.pi * (np.arange(samples) / samples * random.uniform(0.6, 1.4) + random.random())
    displacement, force = np.sin(phase), np.cos(phase)
    if kind == "noise":
        displacement, force = random.standard_normal((2, samples))
    elif kind == "steps":
        displacement = np.round(displacement * random.integers(1, 5))
    elif kind == "elastic":
        force = 0.5 * displacement + 1e-9 * force
    else:
        force = np.where(random.random(samples) < 0.2, 9.0 * random.standard_normal(samples), np.sign(force))
    # a warning is an error here, so nothing may be divided by what these loops do not have
    with contextlib.suppress(LoopError):
        figures = analyse_loop(displacement, force, 2.0)
        assert math.isfinite(figures.slip_amplitude_um.value)
        assert math.isfinite(figures.dissipated_energy_mJ.value)


@pytest.mark.parametrize(("sample", "share"), [(20, 0.54), (40, 0.7), (148, 0.6), (222, 0.3)])
def test_a_spike_to_the_middle_is_left_out_though_a_stiff_rig_jumps_at_reversals(sample: int, share: float) -> None:
    random = np.random.default_rng(3)
    time_s = np.arange(256) / 512.0
    phase = 4.0 * np.pi * time_s
    displacement_um = 38.0 * np.sin(phase)
    # Behind a rigid rig the force turns within a third of a micrometre.
    travel_um = np.where(np.cos(phase) > 0.0, displacement_um + 38.0, 38.0 - displacement_um)
    force_N = np.sign(np.cos(phase)) * np.minimum(travel_um / 0.15 - 1.0, 1.0)
    force_N = force_N + random.normal(0.0, 0.0045, 256)
    spiky = force_N.copy()
    spiky[sample] *= share
    assert clean_loop(displacement_um, force_N, time_s=time_s).outliers == ()
    assert clean_loop(displacement_um, spiky, time_s=time_s).outliers == (sample,)


def broken(index: int, value: float) -> np.ndarray:
    values = np.sin(np.linspace(0.0, 6.2, 100))
    values[index] = value
    return values


SINE, COSINE = np.sin(np.linspace(0.0, 6.2, 100)), np.cos(np.linspace(0.0, 6.2, 100))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((SINE[:10], COSINE[:10]), "at least 16 samples, not 10"),
        ((SINE, COSINE[:50]), "tangential_force_N has 50 samples where displacement_um has 100"),
        ((broken(7, math.nan), COSINE), "displacement_um must be finite, but sample 7 is nan"),
        ((SINE, broken(3, math.inf)), "tangential_force_N must be finite, but sample 3 is inf"),
        ((1e200 * SINE, COSINE), r"displacement_um must be below 1e\+50 in size, as any sensor reads, but sample 1 is"),
        ((SINE, broken(9, 1e200)), r"tangential_force_N must be below 1e\+50 in size, .* but sample 9 is 1e\+200"),
        ((SINE, COSINE, 1e-200), "normal_force_N must be positive"),
        ((np.zeros(100), COSINE), "displacement_um never changes"),
        ((1e-200 * SINE, COSINE), "displacement_um never changes"),
        ((SINE, np.ones(100)), "tangential_force_N never changes"),
        ((SINE, COSINE, -2.0), "normal_force_N must be positive"),
        ((SINE.reshape(10, 10), COSINE), "displacement_um must be one row"),
        ((["a"] * 100, COSINE), "displacement_um must hold numbers only"),
        ((np.sin(np.linspace(0, 25, 400)), np.cos(np.linspace(0, 25, 400))), "one cycle was expected"),
        ((np.linspace(0.0, 1.0, 100), SINE), "not a whole cycle"),
    ],
)
def test_unusable_samples_are_refused_in_one_sentence(arguments: tuple[object, ...], message: str) -> None:
    with pytest.raises(LoopError, match=message) as caught:
        analyse_loop(*arguments)  # type: ignore[arg-type]
    assert isinstance(caught.value, WirewearError)


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


@pytest.mark.parametrize("step", [0.0009, 0.0023, 0.3081])
def test_the_step_of_a_channel_written_with_four_digits_is_found(step: float) -> None:
    assert step_of(np.round(step * np.round(60.0 * channel()), 4)) == pytest.approx(step, rel=2e-3)


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
@pytest.mark.parametrize("noise", [0.0, 0.005])
@pytest.mark.parametrize(("lag", "note"), [(3, "samples late"), (5, "samples late"), (-3, "before the reversals")])
def test_a_late_channel_is_noted_and_intervals_hold_the_truth(samples: int, noise: float, lag: int, note: str) -> None:
    """A late force is read as much earlier; few or noiseless samples show a late displacement."""
    if lag < 0 and noise and samples > 128:
        return
    time, displacement, force = LOOP.sampled(samples, 0.3)
    displacement, force = disturbed(displacement, np.roll(force, lag), 2, noise, 0.0)
    figures = analyse_loop(displacement, force, 2.0, time_s=time)
    assert any(note in said for said in figures.notes)
    assert lag < 0 or figures.dissipated_energy_mJ.value == pytest.approx(LOOP.energy_mJ, rel=0.02)
    for figure, truth in (
        (figures.dissipated_energy_mJ, LOOP.energy_mJ),
        (figures.slip_amplitude_um, LOOP.slip_amplitude_um),
    ):
        assert figure.interval95[0] <= truth <= figure.interval95[1]


@pytest.mark.parametrize("lag", [-5.0, -2.0, 0.0, 1.0, 4.0])
@pytest.mark.parametrize("share", [0.0, 1.0], ids=["spring", "Mindlin"])
def test_a_lag_is_found_whatever_of_spring_or_contact_takes_up_the_rise(lag: float, share: float) -> None:
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
def test_a_displacement_that_drifts_is_noted_and_freed_from_it(noise: float, drift: float, start: float) -> None:
    time, displacement, force = LOOP.sampled(256, start)
    displacement, force = disturbed(displacement, force, 3, noise, 0.0)
    figures = analyse_loop(displacement + drift * 120.0 * time, force, 2.0, time_s=time)
    assert any("drifts by" in note for note in figures.notes)
    assert figures.dissipated_energy_mJ.value == pytest.approx(LOOP.energy_mJ, rel=0.01)
    assert figures.slip_amplitude_um.value == pytest.approx(LOOP.slip_amplitude_um, rel=0.01)


def test_a_possible_drift_is_removable_and_open_or_short_cycles_have_none() -> None:
    time = np.arange(60) / 60
    drive, force = 60.0 * np.sin(2.0 * np.pi * time), np.sign(np.cos(2.0 * np.pi * time))
    wandering = drive + 2.4 * time + 0.05 * np.random.default_rng(1).standard_normal(60)
    still = clean_loop(wandering, force, time_s=time).without_drift
    assert np.polyfit(still.time, still.displacement_um - drive[still.index], 1)[0] == pytest.approx(0.0, abs=0.3)
    early = np.arange(190) / 200
    phase = 2.0 * np.pi * early
    assert drift_of(early, 60.0 * np.sin(phase)) == Drift()
    opened = clean_loop(60.0 * np.sin(phase), np.sign(np.cos(phase)))
    assert f"is open by {0.5 * abs(np.sin(phase[-1])):.0%} of" in " ".join(opened.notes)


def test_the_shortest_tour_of_a_squares_corners_is_its_outline() -> None:
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    for order in permutations(range(4)):
        assert step_lengths(corners, shortened(corners, np.array(order))).sum() == pytest.approx(4.0)


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
def test_a_cycles_period_is_found_from_its_drive_where_steps_are_uneven(start: float, last: float) -> None:
    """Whatever the last step is: the mean of the others, or their median, miss it by up to 4 % of the period."""
    random = np.random.default_rng(1)
    steps = np.append(random.uniform(0.3, 2.0, 63), last)
    time = np.cumsum(steps)[:-1] / steps.sum()
    displacement = 60.0 * np.sin(2.0 * np.pi * (time + start)) + 0.15 * random.standard_normal(time.size)
    assert period_of(time, displacement) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize(("step", "samples"), [(0.05, 256), (0.1, 256), (0.1, 1024), (0.2, 512)])
@pytest.mark.parametrize("start", [0.0, 0.13, 0.31])
def test_a_force_that_stays_on_its_step_behind_a_reversal_is_not_late(step: float, samples: int, start: float) -> None:
    """Nor is a displacement of coarse steps: a lag that they may hide is not certain."""
    loop = SyntheticLoop(Recipe(friction=0.6, contact_stiffness=1e6))
    random = np.random.default_rng(5)
    time, displacement, force = loop.sampled(samples, start)
    force = step * np.round((force + 0.005 * random.standard_normal(samples)) / step)
    for read in (displacement + 0.1 * random.standard_normal(samples), 2.0 * np.round(0.5 * displacement)):
        figures = analyse_loop(read, force, 2.0, time_s=time)
        assert not any("late" in note or "before the reversals" in note for note in figures.notes)
        assert figures.dissipated_energy_mJ.value == pytest.approx(loop.energy_mJ, rel=0.005)
        assert figures.slip_amplitude_um.value == pytest.approx(loop.slip_amplitude_um, rel=0.01)
    stiffness = analyse_loop(displacement, force, 2.0, time_s=time).measured_stiffness_N_per_um
    assert stiffness is not None
    assert stiffness.interval95[0] <= 0.167 <= stiffness.interval95[1]
    assert stiffness.value == pytest.approx(0.167, rel=0.5 * step)
