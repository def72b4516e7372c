"""Distortions outside the library: closed-form evidence, and records whose readings are bent in known ways."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from geometry.arrays import Array
from studies.diagnosis.gap_free_pairs import Pair, pair_of
from tests.diagnosis.diagnosis_cases import diagnosed, nominal, record, states
from wirewear.diagnosis.infer.distortions import _log_evidence
from wirewear.diagnosis.infer.families import (
    FAMILIES,
    Branches,
    displacement_after_play,
    force_after_play,
    force_read,
    stiffening,
)
from wirewear.diagnosis.observe.reduction import Observations, reduce
from wirewear.diagnosis.surrogate.forward import simulate
from wirewear.records import ExperimentRecord, MeasuredLoop

PLATEAU_N, AMPLITUDE_um = 0.62 * 2.0, 60.0
Change = Callable[[MeasuredLoop], MeasuredLoop]


def bent(change: Change, one: ExperimentRecord | None = None) -> ExperimentRecord:
    one = one or record(evolution=False)
    return replace(one, loops=tuple(map(change, one.loops)))


def saturating(loop: MeasuredLoop) -> MeasuredLoop:
    """A force cell that reads 20 % less at the plateau force, ever less above."""
    force = loop.tangential_force_N
    return replace(loop, tangential_force_N=force * (1.0 - 0.2 * (force / PLATEAU_N) ** 2))


def grinding(loop: MeasuredLoop) -> MeasuredLoop:
    """Friction that is 12 % higher at both ends of the stroke, while the contact slides."""
    place, forward = loop.displacement_um / AMPLITUDE_um, np.gradient(loop.displacement_um) > 0.0
    slides = np.where(forward, loop.tangential_force_N, -loop.tangential_force_N) > 0.7 * PLATEAU_N
    added = 0.12 * PLATEAU_N * place**2 * np.where(forward, 1.0, -1.0)
    return replace(loop, tangential_force_N=loop.tangential_force_N + np.where(slides, added, 0.0))


def creeping(loop: MeasuredLoop) -> MeasuredLoop:
    """A charge amplifier whose zero has crept by 0.1 N at 100 000 cycles; the normal force knows nothing of it."""
    return replace(loop, tangential_force_N=loop.tangential_force_N + 0.02 * np.log10(loop.cycle))


def test_evidence_is_that_of_the_normal_distribution_with_both_spaces_in_its_covariance() -> None:
    random = np.random.default_rng(1)
    residual, columns = random.standard_normal(7), random.standard_normal((7, 3))
    whole = multivariate_normal(np.zeros(7), np.eye(7) + columns @ columns.T).logpdf(residual)
    assert _log_evidence(residual, columns) - 0.0 == pytest.approx(float(whole) + 3.5 * np.log(2.0 * np.pi))


@pytest.mark.slow
def test_a_saturating_force_cell_is_found_with_its_seam_and_size() -> None:
    """What a compliance, a gain or another friction leaves of it is a cubic in Q."""
    answer = diagnosed(bent(saturating)).diagnosis
    assert answer.verdict == "unexplained"
    first = answer.resembles[0]
    assert first.seam == "sensor"
    assert "force channel, odd" in first.family or "displacement channel, odd" in first.family
    assert answer.sentence.endswith(first.text)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "seams", "words"),
    [(grinding, {"contact", "loading"}, "alike on both sides"), (creeping, {"sensor"}, "zero of the force channel")],
)
def test_what_is_bent_elsewhere_is_placed_there(change: Change, seams: set[str], words: str) -> None:
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
            assert after.displacement_um == pytest.approx(before.loops.displacement_um, abs=1e-9)
            assert after.tangential_force_N == pytest.approx(before.loops.tangential_force_N, abs=1e-9)


def test_a_force_channel_is_bent_by_its_own_formula() -> None:
    before = branches()

    def cubed(u: Array) -> Array:
        return np.asarray(u**3)

    force = before.loops.tangential_force_N
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
    force, place = before.loops.tangential_force_N, before.loops.displacement_um
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
    assert after.tangential_force_N == pytest.approx(before.loops.tangential_force_N)
    change = after.displacement_um - before.loops.displacement_um
    assert change[0, 0] == pytest.approx(-change[0, 1], abs=1e-6 * before.amplitude_um)
    assert np.abs(change[:, :, -1]).max() < 1e-9
    assert change[0, 0, 0] == pytest.approx(0.0, abs=1e-9)


@pytest.fixture(scope="module")
def observed() -> Observations:
    """What is observed of two tests that the fast model made, without any scatter between them."""
    return reduce(record(repeats=2, scatter=0.0, cycles=(1, 10, 100, 1000, 10_000, 30_000, 100_000)))


def paired(observed: Observations, **options: bool) -> Pair:
    return pair_of("made_T1_003", "a test", states(), nominal("sensor"), observed, **options)


def test_a_record_of_the_model_itself_differs_from_it_by_noise_alone(observed: Observations) -> None:
    pair = paired(observed)
    assert np.mean((pair.residual / np.sqrt(np.diag(pair.fixed))) ** 2) < 1.5
    unlike = pair_of("made_T1_003", "a test", states(), replace(nominal("sensor"), friction_factor=1.1), observed)
    assert np.mean((unlike.residual / np.sqrt(np.diag(unlike.fixed))) ** 2) > 10.0


def test_covariances_are_symmetric_and_of_no_negative_variance_and_scatter_adds_to_them(observed: Observations) -> None:
    pair, scattered = paired(observed), paired(observed, scattered=True)
    for matrix in (pair.fixed, scattered.fixed, scattered.fixed - pair.fixed, *pair.parts.values()):
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * np.abs(matrix).max())
        least, *_, largest = np.linalg.eigvalsh(matrix)
        assert least > -1e-9 * largest
    assert np.trace(scattered.fixed) > np.trace(pair.fixed)
    assert pair.freedoms.shape[0] == pair.residual.size
    assert np.isfinite(pair.freedoms).all()
