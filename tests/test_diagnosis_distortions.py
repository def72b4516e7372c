"""Distortions outside the library: closed-form evidence, and records whose readings are bent in known ways."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from geometry.arrays import Array
from tests.diagnosis_cases import diagnosed, nominal, record, states
from wirewear.diagnosis.infer.distortions import _log_evidence
from wirewear.diagnosis.infer.families import FAMILIES
from wirewear.diagnosis.infer.full_sampling import Ripple, ripple
from wirewear.diagnosis.infer.shapes import Branches, displacement_after_play, force_after_play, force_read, stiffening
from wirewear.diagnosis.model.candidates import nominal_setup
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.nominal import nominal_study
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.records import ExperimentRecord, MeasuredLoop
from wirewear.views.diagnosis_wording import Diagnosed

PLATEAU_N, AMPLITUDE_um = 0.62 * 2.0, 60.0

Change = Callable[[MeasuredLoop], MeasuredLoop]


def bent(change: Change, one: ExperimentRecord | None = None) -> ExperimentRecord:
    one = one or record(evolution=False)
    return replace(one, loops=tuple(map(change, one.loops)))


def saturating(loop: MeasuredLoop) -> MeasuredLoop:
    """A force cell that reads 20 % less at the plateau force, ever less above."""
    force = loop.tangential_force_N
    return replace(loop, tangential_force_N=force * (1.0 - 0.2 * (force / PLATEAU_N) ** 2))


def bowed(loop: MeasuredLoop) -> MeasuredLoop:
    """A displacement sensor that reads the middle of the stroke 4 µm too far, alike on both sides."""
    share = loop.displacement_um / AMPLITUDE_um
    return replace(loop, displacement_um=loop.displacement_um + 4.0 * (1.0 - share**2))


def grinding(loop: MeasuredLoop) -> MeasuredLoop:
    """Friction that is 12 % higher at both ends of the stroke, while the contact slides."""
    place, forward = loop.displacement_um / AMPLITUDE_um, np.gradient(loop.displacement_um) > 0.0
    slides = np.where(forward, loop.tangential_force_N, -loop.tangential_force_N) > 0.7 * PLATEAU_N
    added = 0.12 * PLATEAU_N * place**2 * np.where(forward, 1.0, -1.0)
    return replace(loop, tangential_force_N=loop.tangential_force_N + np.where(slides, added, 0.0))


def creeping(loop: MeasuredLoop) -> MeasuredLoop:
    """A charge amplifier whose zero has crept by 0.1 N at 100 000 cycles; the normal force knows nothing of it."""
    return replace(loop, tangential_force_N=loop.tangential_force_N + 0.02 * np.log10(loop.cycle))


@cache
def saturated() -> Diagnosed:
    return diagnosed(bent(saturating))


def test_evidence_is_that_of_the_normal_distribution_with_both_spaces_in_its_covariance() -> None:
    random = np.random.default_rng(1)
    residual, columns = random.standard_normal(7), random.standard_normal((7, 3))
    whole = multivariate_normal(np.zeros(7), np.eye(7) + columns @ columns.T).logpdf(residual)
    assert _log_evidence(residual, columns) - 0.0 == pytest.approx(float(whole) + 3.5 * np.log(2.0 * np.pi))


@pytest.mark.slow
def test_a_saturating_force_cell_is_told_with_its_seam_and_size() -> None:
    """What a compliance, a gain or another friction leaves of it is a cubic in Q."""
    answer = saturated().diagnosis
    assert answer.verdict == "unexplained"
    first = answer.resembles[0]
    assert first.seam == "sensor"
    assert "force channel, odd" in first.family or "displacement channel, odd" in first.family
    assert answer.sentence.endswith(first.text)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "seams", "words"),
    [
        (bowed, {"sensor"}, "displacement channel, even"),
        (grinding, {"contact", "loading"}, "alike on both sides"),
        (creeping, {"sensor"}, "zero of the force channel"),
    ],
)
def test_what_is_bent_elsewhere_is_told_there(change: Change, seams: set[str], words: str) -> None:
    answer = diagnosed(bent(change)).diagnosis
    assert answer.verdict == "unexplained"
    assert answer.resembles[0].seam in seams
    assert words in answer.resembles[0].family


def branches() -> Branches:
    setup = nominal("sensor")
    return Branches.of(simulate(states(), setup, np.array([1000.0])), setup.amplitude_um, setup.plateau_force_N)


def test_a_distortion_of_no_size_changes_nothing() -> None:
    before = branches()
    for family in FAMILIES:
        for shape in family.shapes:
            after = shape(before, 0.0)
            assert after.displacement_um == pytest.approx(before.course.displacement_um, abs=1e-9)
            assert after.tangential_force_N == pytest.approx(before.course.tangential_force_N, abs=1e-9)


def test_a_force_channel_is_bent_by_its_own_formula() -> None:
    before = branches()

    def cubed(u: Array) -> Array:
        return np.asarray(u**3)

    force = before.course.tangential_force_N
    after = force_read(cubed)(before, 0.1).tangential_force_N
    assert after == pytest.approx(force + 0.1 * before.force_N * (force / before.force_N) ** 3)


def after_play(periodic: Array, play: float) -> Array:
    """What follows a periodic channel with a play, step by step, once round and again."""
    at, followed = float(periodic[0]), []
    for value in [*periodic, *periodic]:
        at = min(max(at, value - 0.5 * play), value + 0.5 * play)
        followed.append(at)
    return np.array(followed[periodic.size :])


def test_channels_with_a_play_follow_as_a_pawl_does_step_by_step() -> None:
    before = branches()
    force, place = before.course.tangential_force_N, before.course.displacement_um
    by_force = force_after_play()(before, 0.05).tangential_force_N
    expected = after_play(force.ravel(), 0.1 * before.force_N)
    assert by_force.ravel() == pytest.approx(expected, abs=2e-3 * before.force_N)
    free, held = (displacement_after_play(held=own)(before, 0.05).displacement_um for own in (False, True))
    expected = after_play(place.ravel(), 0.1 * before.amplitude_um)
    assert free.ravel() == pytest.approx(expected, abs=2e-3 * before.amplitude_um)
    assert np.ptp(held) == pytest.approx(np.ptp(place), rel=2e-3)


def test_a_holder_that_stiffens_keeps_forces_and_bends_what_sticks_alone() -> None:
    before = branches()
    after = stiffening()(before, 0.02)
    assert after.tangential_force_N == pytest.approx(before.course.tangential_force_N)
    change = after.displacement_um - before.course.displacement_um
    assert change[0, 0] == pytest.approx(-change[0, 1], abs=1e-6 * before.amplitude_um)
    assert np.abs(change[:, :, -1]).max() < 1e-9
    assert change[0, 0, 0] == pytest.approx(0.0, abs=1e-9)


def rippled(amplitude_N: float, along: str) -> ExperimentRecord:
    """Loops with a ripple of 7 µm along the stroke that turns with the direction, or with hum of 50 Hz."""

    def change(loop: MeasuredLoop) -> MeasuredLoop:
        direction = np.sign(np.gradient(loop.displacement_um))
        slides = direction * loop.tangential_force_N > 0.7 * PLATEAU_N
        wave = direction * np.sin(2.0 * np.pi * loop.displacement_um / 7.0) * slides
        if along == "time":
            wave = np.sin(2.0 * np.pi * 50.0 * loop.time_s + 1.3 * loop.cycle + loop.repeat)
        return replace(loop, tangential_force_N=loop.tangential_force_N + amplitude_N * wave)

    return bent(change)


def found_ripple(one: ExperimentRecord) -> Ripple | None:
    setup = nominal_setup(nominal_study(one), "sensor")
    return ripple(states(), setup, reduce(one).loops)


@pytest.mark.seconds
def test_a_ripple_of_the_noises_height_is_seen_at_full_sampling() -> None:
    wave = found_ripple(rippled(0.008, "stroke"))
    assert wave is not None
    assert wave.along == "stroke"
    assert wave.length == pytest.approx(7.0, rel=0.03)
    assert wave.amplitude_N == pytest.approx(0.008, rel=0.3)
    assert wave.p_value < 1e-20
