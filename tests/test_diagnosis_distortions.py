"""Distortions outside the library: closed-form evidence, and records whose readings are bent in known ways."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from tests.diagnosis_cases import diagnosed, nominal, record, states
from wirewear.diagnosis.infer.distortions import _log_evidence, gains_of
from wirewear.diagnosis.infer.families import FAMILIES
from wirewear.diagnosis.infer.family_columns import columns_of
from wirewear.diagnosis.infer.full_sampling import Ripple, ripple
from wirewear.diagnosis.infer.inference import fit, jacobian_of
from wirewear.diagnosis.infer.shapes import (
    Branches,
    displacement_after_play,
    force_after_play,
    force_read,
    resisting,
    stiffening,
)
from wirewear.diagnosis.model.candidates import nominal_setup
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.nominal import nominal_study
from wirewear.diagnosis.model.setup import Array
from wirewear.diagnosis.observe.local_lines import ObservedBranch
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.effects import Seam
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
def test_linear_evidence_beside_an_explanation_is_that_of_its_fit() -> None:
    """Laplace's evidence of a fit and the closed form about it are two ways to one number where the model is linear."""
    found = saturated().search
    for one in found.singles[:4]:
        again = fit(found.problem, one.candidates, [one.coordinates])
        jacobian = jacobian_of(found.problem, again)
        residual = found.problem.whitened(again.setup) - jacobian @ again.coordinates
        assert _log_evidence(residual, jacobian) == pytest.approx(again.log_evidence, rel=0.03, abs=0.3)


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


@pytest.mark.slow
def test_nothing_outside_the_library_stands_out_of_records_within_it() -> None:
    for effects in (None, {"free_play": {"gap_um": 3.0}}, {"tangential_compliance": {"stiffness_N_per_mm": 400.0}}):
        found = diagnosed(record(effects, seed=4))
        assert found.diagnosis.resembles == ()
        assert max(one.log_evidence for one in found.search.distortions) < found.search.best.log_evidence + 3.0


@pytest.mark.slow
def test_every_seam_has_a_family_and_every_family_columns_that_are_seen() -> None:
    assert {family.seam for family in FAMILIES} == set(Seam)
    found = saturated().search
    for sets in columns_of(found.problem, found.none.setup):
        assert sum(columns.weight for columns in sets) == pytest.approx(1.0)
        for columns in sets:
            assert np.isfinite(columns.observed).all(), columns.family.name
            assert np.abs(found.problem.whitening @ columns.observed).max() > 1.0, columns.family.name


@pytest.mark.slow
def test_what_changes_in_time_may_settle_and_a_cell_may_saturate() -> None:
    """A course that settles is one unknown: it pays for one, where a free one pays for each of its knots."""
    found = saturated().search
    sets = {one[0].family.name: one for one in columns_of(found.problem, found.none.setup)}
    free, *settling = sets["zero of the force channel that changes over the test"]
    assert free.observed.shape[1] == free.knots.size == len(settling) + 1
    for columns in settling:
        course = columns.of_unknowns[:, 0]
        assert 0.0 <= course[0] < course[-1] <= 1.0
        assert (np.diff(course) >= 0.0).all()
    bent_cell = next(one for one in found.distortions if one.family.name == "distortion of the force channel, odd in Q")
    assert bent_cell.unknowns == pytest.approx([-0.2], rel=0.1)


@pytest.mark.slow
def test_gains_stand_beside_the_explanations_they_were_tried_with() -> None:
    found = saturated().search
    gains = gains_of(found.distortions)
    assert () in gains
    assert set(map(len, gains.values())) == {sum(family.counts for family in FAMILIES)}


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


def test_resistance_goes_on_where_the_other_branch_ended_and_keeps_the_stroke() -> None:
    before = branches()
    after = resisting(lambda b: np.asarray(b.place**2))(before, 0.2)
    force, place = after.tangential_force_N, after.displacement_um
    assert force[0, 0, 0] == pytest.approx(force[0, 1, -1])
    assert force[0, 1, 0] == pytest.approx(force[0, 0, -1])
    assert np.ptp(place) == pytest.approx(np.ptp(before.course.displacement_um))
    assert (np.diff(place[0, 0]) >= 0.0).all()


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


def test_a_ripple_of_the_noises_height_is_seen_at_full_sampling() -> None:
    wave = found_ripple(rippled(0.008, "stroke"))
    assert wave is not None
    assert wave.along == "stroke"
    assert wave.length == pytest.approx(7.0, rel=0.03)
    assert wave.amplitude_N == pytest.approx(0.008, rel=0.3)
    assert wave.p_value < 1e-20


def test_hum_is_told_from_what_stays_at_its_place() -> None:
    wave = found_ripple(rippled(0.02, "time"))
    assert wave is not None
    assert wave.along == "time"
    assert wave.length == pytest.approx(50.0, rel=0.1)


def test_noise_makes_no_ripple() -> None:
    assert all(found_ripple(record(seed=seed, repeats=1, evolution=False)) is None for seed in range(6))


@pytest.mark.slow
def test_a_ripple_along_the_stroke_is_a_gap_that_no_known_effect_explains() -> None:
    answer = diagnosed(rippled(0.03, "stroke")).diagnosis
    assert answer.verdict == "unexplained"
    assert "ripples along the stroke" in answer.sentence
    assert answer.resembles[0].family == "ripple of the friction along the stroke"
    hum = diagnosed(rippled(0.01, "time")).diagnosis
    assert hum.verdict == "no_gap"
    assert any("as hum or vibration does" in note for note in hum.notes)


@pytest.mark.slow
@pytest.mark.parametrize("offset_N", [0.0, -0.05])
def test_a_zero_far_from_what_is_expected_is_noted_with_its_size(offset_N: float) -> None:
    """Crosstalk would move the normal force, too; a wire that leans is not considered."""
    shifted = bent(lambda loop: replace(loop, tangential_force_N=loop.tangential_force_N + offset_N))
    notes = [note for note in diagnosed(shifted, "misalignment").diagnosis.notes if "zero of the force" in note]
    told = [float(note.partition("lies at ")[2].partition(" N")[0].replace("−", "-")) for note in notes]
    assert told == ([] if offset_N == 0.0 else [pytest.approx(offset_N, rel=0.2)])


def test_stick_beyond_the_end_of_sliding_is_no_ripple() -> None:
    """A reading that leans against the force goes on outwards there: its samples are no part of the plateau."""
    setup = nominal("sensor")

    def running_on(branch: ObservedBranch) -> ObservedBranch:
        top_um, top_N = branch.displacement_um[-1], branch.force_N[-1]
        beyond = np.linspace(0.05, 1.0, 25)
        return replace(
            branch,
            displacement_um=np.concatenate([branch.displacement_um, top_um + beyond]),
            force_N=np.concatenate([branch.force_N, top_N * (1.0 - 0.5 * beyond)]),
        )

    loops = reduce(record(samples=400, scatter=0.0)).loops
    leaning = tuple(
        replace(loop, branches=(running_on(loop.branches[0]), running_on(loop.branches[1]))) for loop in loops
    )
    assert ripple(states(), setup, loops) is None
    assert ripple(states(), setup, leaning) is None
