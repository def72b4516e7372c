"""Shapes at seams that only name: loggers, amplifiers, joints, spots, loads that rattle, and records with each."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from geometry.arrays import Array
from studies.diagnosis.gap_free_pairs import Pair, pair_of
from tests.diagnosis_cases import diagnosed, nominal, record, states
from wirewear.diagnosis.infer.shapes import Branches, opening
from wirewear.diagnosis.infer.shapes_in_time import averaged, rattling, slewing
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.readings import phases_of
from wirewear.diagnosis.observe.reduction import Observations, reduce
from wirewear.records import MeasuredLoop

PLATEAU_N, AMPLITUDE_um = 0.62 * 2.0, 60.0


@pytest.fixture(scope="module")
def observed() -> Observations:
    """What is observed of two tests that the fast model made, without any scatter between them."""
    return reduce(record(repeats=2, scatter=0.0, cycles=(1, 10, 100, 1000, 10_000, 30_000, 100_000)))


def paired(observed: Observations, **options: bool) -> Pair:
    return pair_of("made_T1_003", "a test", states(), nominal("sensor"), observed, **options)


def smallest_share(matrix: Array) -> float:
    """The least eigenvalue over the largest."""
    values = np.linalg.eigvalsh(matrix)
    return float(values[0] / values[-1])


def test_a_record_of_the_model_itself_differs_from_it_by_noise_alone(observed: Observations) -> None:
    pair = paired(observed)
    deviates = pair.residual / np.sqrt(np.diag(pair.fixed))
    assert np.mean(deviates**2) < 1.5
    unlike = pair_of("made_T1_003", "a test", states(), replace(nominal("sensor"), friction_factor=1.1), observed)
    assert np.mean((unlike.residual / np.sqrt(np.diag(unlike.fixed))) ** 2) > 10.0


def test_covariances_are_symmetric_and_of_no_negative_variance_and_scatter_adds_to_them(observed: Observations) -> None:
    pair, scattered = paired(observed), paired(observed, scattered=True)
    for matrix in (pair.fixed, scattered.fixed, scattered.fixed - pair.fixed, *pair.parts.values()):
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * np.abs(matrix).max())
        assert smallest_share(matrix) > -1e-9
    assert np.trace(scattered.fixed) > np.trace(pair.fixed)
    assert pair.freedoms.shape[0] == pair.residual.size
    assert np.isfinite(pair.freedoms).all()


def branches() -> Branches:
    setup = nominal("sensor")
    course = simulate(states(), setup, np.array([1000.0, 30_000.0]))
    return Branches.of(course, setup.amplitude_um, setup.plateau_force_N)


def evenly(b: Branches, values: Array) -> Array:
    """A channel of the first loop at a thousand even phases."""
    phases = phases_of(b.course.displacement_um, b.motion)[0].ravel()
    even = np.interp(np.arange(1000) * 2.0 * np.pi / 1000, phases, values[0].ravel(), period=2.0 * np.pi)
    return np.asarray(even)


def test_a_logger_takes_the_mean_of_a_window_about_each_sample() -> None:
    before = branches()
    after = averaged(0.05)(before, 1.0)
    window = np.zeros(1000)
    window[np.arange(-25, 26)] = np.r_[0.5, np.ones(49), 0.5] / 50.0
    force = evenly(before, before.course.tangential_force_N)
    expected = np.fft.irfft(np.fft.rfft(force) * np.fft.rfft(window), 1000)
    assert np.abs(evenly(before, after.tangential_force_N) - expected).max() < 0.01 * before.force_N
    assert np.ptp(after.displacement_um) < np.ptp(before.course.displacement_um)


def test_a_slow_channel_turns_at_its_rate_and_reaches_the_plateau() -> None:
    before = branches()
    after = slewing(0.5)(before, 1.0).tangential_force_N
    own, slow = (np.abs(np.diff(evenly(before, q))).max() for q in (before.course.tangential_force_N, after))
    # Steep flanks have few points, and go straight between them.
    assert slow == pytest.approx(0.5 * own, rel=0.25)
    middle = before.place[0, 0].searchsorted(0.3)
    assert after[0, 0, middle:] == pytest.approx(before.course.tangential_force_N[0, 0, middle:])


def test_a_joint_gives_nothing_below_the_force_that_opens_it() -> None:
    before = branches()
    change = opening(0.5)(before, 0.02).displacement_um - before.course.displacement_um
    sticks = before.p_N[0, 0] < 0.45 * before.force_N
    given = change[0, 0, sticks & (before.p_N[0, 0] > -0.45 * before.force_N)]
    assert np.ptp(given) < 1e-9
    assert change[0, 0] == pytest.approx(-change[0, 1], abs=1e-6 * before.amplitude_um)
    assert np.abs(change[0, 0]).max() > 0.005 * before.amplitude_um


def test_a_loose_load_swings_after_each_reversal_and_both_forces_with_it() -> None:
    before = branches()
    sine, cosine = rattling(6.0, 0.09)
    load = before.course.normal_force_N
    swung = [shape(before, 0.1).normal_force_N / load - 1.0 for shape in (sine, cosine)]
    assert swung[0][:, :, 0] == pytest.approx(0.0, abs=1e-12)
    assert swung[1][:, :, 0] == pytest.approx(0.1)
    for share in swung:
        assert share[:, 0] == pytest.approx(share[:, 1], abs=1e-9)
        assert np.abs(share[:, :, -1]).max() < 0.1 * np.exp(-0.5 / 0.09) + 1e-9
    sliding = slice(-20, None)
    forces = sine(before, 0.1).tangential_force_N[:, :, sliding] / before.course.tangential_force_N[:, :, sliding]
    assert forces - 1.0 == pytest.approx(swung[0][:, :, sliding], abs=1e-6)


def slow(loop: MeasuredLoop) -> MeasuredLoop:
    """An amplifier that turns the force within a fifth of a cycle at best, sample by sample."""
    steps = np.diff(loop.time_s, append=loop.time_s[0] + 1.0 / 3.0)
    at, read = float(loop.tangential_force_N[-1]), []
    for value, step in [*zip(loop.tangential_force_N, steps, strict=True)] * 2:
        most = 2.0 * PLATEAU_N / (0.2 / 3.0) * step
        at = min(max(float(value), at - most), at + most)
        read.append(at)
    return replace(loop, tangential_force_N=np.array(read[loop.time_s.size :]))


def smeared(loop: MeasuredLoop) -> MeasuredLoop:
    """A logger that takes the mean of fifteen of its two hundred samples."""

    def mean(channel: Array) -> Array:
        return np.asarray(np.mean([np.roll(channel, shift) for shift in range(-7, 8)], axis=0))

    assert loop.normal_force_N is not None
    return replace(
        loop,
        displacement_um=mean(loop.displacement_um),
        tangential_force_N=mean(loop.tangential_force_N),
        normal_force_N=mean(loop.normal_force_N),
    )


def spotted(loop: MeasuredLoop) -> MeasuredLoop:
    """Friction a fifth higher over some micrometres to one side of the middle."""
    away = (loop.displacement_um / AMPLITUDE_um - 0.25) / 0.12
    return replace(loop, tangential_force_N=loop.tangential_force_N * (1.0 + 0.2 * np.exp(-(away**2))))


def rattled(loop: MeasuredLoop) -> MeasuredLoop:
    """A load that swings by a fifth after each reversal, two and a half times within what it fades in."""
    ends = loop.time_s[[int(loop.displacement_um.argmax()), int(loop.displacement_um.argmin())]]
    since = 3.0 * np.min([(loop.time_s - end) % (1.0 / 3.0) for end in ends], axis=0)
    load = 1.0 + 0.2 * np.exp(-since / 0.09) * np.sin(2.0 * np.pi * 6.0 * since)
    assert loop.normal_force_N is not None
    return replace(loop, tangential_force_N=loop.tangential_force_N * load, normal_force_N=loop.normal_force_N * load)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "seam", "words"),
    [
        (slow, "sensor", "no faster than a rate"),
        (smeared, "sensor", "averages over a time"),
        (spotted, "contact", "at one place"),
        (rattled, "loading", "rattles"),
    ],
)
def test_what_a_rig_does_to_its_loops_is_told_by_its_seam(
    change: Callable[[MeasuredLoop], MeasuredLoop], seam: str, words: str
) -> None:
    one = record(evolution=False, repeats=1)
    answer = diagnosed(replace(one, loops=tuple(map(change, one.loops)))).diagnosis
    assert answer.verdict == "unexplained"
    assert answer.resembles[0].seam == seam
    assert words in answer.resembles[0].family
