"""Loops with increments where the force bends, against loops of 400 increments."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import solvers
from geometry.arrays import Array
from solvers.contact_state import Guide, Stroke
from solvers.wear_path import wear_path
from solvers.wear_step.symmetry import Mirror, with_images
from tests.bodies import FRICTION, LOAD_N, AMPLITUDE_mm, RIG_N_per_mm, crossed_wires, pressed
from wirewear.loops.sensor import enclosed_area

amplitudes = st.floats(1e-4, 10.0)
#: Share of the amplitude by which the contact has carried its holder along.
carried = st.floats(-0.2, 1.2)
counts = st.integers(2, 200)
MIRROR = Mirror(-1.0, 1.0, np.array([2, 1, 0]), np.array([1, 0]))
INCREMENTS = 32
SLIDING_N = FRICTION * LOAD_N
PLAY_mm = 0.006


@given(amplitudes, carried, counts)
def test_a_stroke_ends_at_the_other_end_and_never_turns_back(amplitude: float, share: float, count: int) -> None:
    places = wear_path(amplitude, share * amplitude, count)
    assert places.shape == (count,)
    assert places[-1] == -amplitude
    assert (np.diff(places, prepend=amplitude) < 0.0).all()


@given(amplitudes, st.floats(0.0, 0.7), st.integers(6, 200))
def test_places_of_one_stroke_lie_between_those_of_the_other(amplitude: float, share: float, count: int) -> None:
    holder = share * amplitude
    places = wear_path(amplitude, holder, count)
    # Where the bodies meet: the drive less the holder's place, which is carried along to either side in turn.
    there = places[1:-1] + holder
    both = np.sort(np.concatenate([there, -there[::-1]]))
    slides = amplitude - holder
    spacing = 2.0 * slides / (count - 2)
    assert np.allclose(np.diff(both), 0.5 * spacing, rtol=1e-9, atol=1e-12 * amplitude)
    assert np.abs(both).max() <= slides
    assert places[0] == pytest.approx(0.5 * (amplitude + places[1]))


@given(amplitudes, st.floats(0.76, 1.2), counts)
def test_a_contact_that_hardly_slides_is_followed_as_the_drive_goes(amplitude: float, share: float, count: int) -> None:
    assume(count >= 4)
    places = wear_path(amplitude, share * amplitude, count)
    assert np.allclose(places, amplitude * np.cos(np.pi * np.arange(1, count + 1) / count))


@given(amplitudes, st.floats(0.05, 0.6), st.floats(0.2, 1.0), st.integers(6, 200))
def test_a_stroke_before_predicts_where_bodies_slide(amplitude: float, share: float, sprung: float, count: int) -> None:
    """The holder springs back by less than it was carried along, and is carried on as the force grows."""
    carried = share * amplitude
    stands = -sprung * carried
    onset = amplitude - (carried - stands)
    drive = np.concatenate([np.linspace(amplitude, onset, 20), np.linspace(onset, -amplitude, 200)[1:]])
    holder = np.where(
        drive >= onset,
        carried - (amplitude - drive),
        stands - (carried + stands) * (onset - drive) / (onset + amplitude),
    )
    places = wear_path(amplitude, carried, count, Stroke(drive[1:], holder[1:]))
    assert places[-1] == -amplitude
    assert (np.diff(places, prepend=amplitude) < 0.0).all()
    assert onset - 0.01 * amplitude < places[0] + 2.0 * (amplitude - carried) / (count - 2)
    # Where the bodies meet, strokes lie between one another as before.
    there = places[1:-1] - np.interp(-places[1:-1], -drive, holder)
    both = np.sort(np.concatenate([there, -there]))
    assert np.allclose(np.diff(both), (amplitude - carried) / (count - 2), rtol=0.02, atol=1e-6 * amplitude)


def half(side: float) -> Guide:
    """The stroke that starts at side x 0.06 mm."""
    drive = side * np.array([0.05, 0.01, -0.03, -0.06])
    traction = np.random.default_rng(4).uniform(size=(4, 3, 3))
    phase = np.array([0.1, 0.2, 0.3, 0.5]) + (0.0 if side > 0.0 else 0.5)
    return Guide(phase, drive, 0.1 * drive + side * 0.007, np.array([1.0, 2.0, 3.0, 4.0]), traction)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_stroke_that_was_recorded_is_guessed_by_its_drive_whatever_the_phase(side: float) -> None:
    guide = half(side)
    guess = guide.at(float(guide.phase[0]), float(guide.drive[2]) + 1e-9)
    assert guess is not None
    assert guess.holder_x == pytest.approx(guide.holder_x[2], abs=1e-9)
    assert np.array_equal(guess.traction, guide.traction[2])
    between = guide.at(float(guide.phase[0]), 0.5 * float(guide.drive[1] + guide.drive[2]))
    assert between is not None
    assert between.holder_x == pytest.approx(0.5 * (guide.holder_x[1] + guide.holder_x[2]))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_other_stroke_is_not_guessed_unless_a_mirror_makes_it(side: float) -> None:
    guide = half(side)
    assert guide.at(0.75 if side > 0.0 else 0.25, 0.0) is None
    whole = with_images(guide, MIRROR)
    assert np.all(np.diff(whole.phase) > 0.0)
    for drive in (-0.04, 0.0, 0.03):
        there, back = whole.at(0.25, drive), whole.at(0.75, -drive)
        assert there is not None
        assert back is not None
        assert back.holder_x == pytest.approx(-there.holder_x)
        assert back.traction == pytest.approx(there.traction[MIRROR.primary] * MIRROR.signs)


def stroke(trace: solvers.CycleTrace, *, falling: bool) -> tuple[Array, Array]:
    """Drive and force of one stroke, from the end before it, in the order of increasing drive."""
    drive, force = (np.append(values[-1], values) for values in (trace.drive, trace.tangential_force))
    part = np.flatnonzero((np.diff(drive) < 0.0) == falling)
    chosen = np.append(part[0], part + 1)
    order = np.argsort(drive[chosen])
    return drive[chosen][order], force[chosen][order]


def distance(coarse: solvers.CycleTrace, fine: solvers.CycleTrace) -> float:
    """Largest distance of the fine loop's force from straight lines between the coarse one's increments, N."""
    pairs = ((stroke(coarse, falling=falling), stroke(fine, falling=falling)) for falling in (True, False))
    return max(float(np.abs(np.interp(x, *line) - q).max()) for line, (x, q) in pairs)


@pytest.fixture(scope="module")
def wires() -> solvers.ContactProblem:
    return crossed_wires(0.010, long_patch=True, rig_N_per_mm=RIG_N_per_mm)


def with_holder(wires: solvers.ContactProblem, name: str) -> solvers.ContactProblem:
    spring = wires.holder
    holders = {"rigid": solvers.Holder(LOAD_N), "spring": spring, "free play": replace(spring, play_mm=PLAY_mm)}
    return replace(wires, holder=holders[name])


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize("holder", ["rigid", "spring", "free play"])
def test_straight_lines_between_increments_follow_a_loop_of_400(wires: solvers.ContactProblem, holder: str) -> None:
    problem = with_holder(wires, holder)
    state = solvers.first_quarter(problem, pressed(problem)[0], solvers.Drive(AMPLITUDE_mm), INCREMENTS)
    _, fine = solvers.closed_cycle(problem, state, solvers.Drive(AMPLITUDE_mm), 400)
    _, loop = solvers.closed_adaptive_cycle(problem, state, solvers.Drive(AMPLITUDE_mm), INCREMENTS)
    assert distance(loop, fine) <= 0.005 * SLIDING_N
    assert len(loop.drive) <= 120
    # As many increments on a cosine do not.
    _, cosine = solvers.closed_cycle(problem, state, solvers.Drive(AMPLITUDE_mm), 4 * (len(loop.drive) // 4))
    assert distance(cosine, fine) > distance(loop, fine)
    area = abs(enclosed_area(loop.drive, loop.tangential_force))
    assert loop.friction_work == pytest.approx(area, rel=1e-3)
    assert loop.friction_work == pytest.approx(fine.friction_work, rel=5e-4)
    # A force that bends one way and back within a step hides from its chord: none is longer than the cosine's, but for
    # the last one of a stroke, which reaches its end if that is at most a quarter farther.
    assert (np.diff(loop.phase) % 1.0).max() < 1.81 / INCREMENTS
    # The way back is the mirror image of the way out.
    half = len(loop.drive) // 2
    assert loop.drive[half:] == pytest.approx(-loop.drive[:half], abs=0.0)
    assert loop.tangential_force[half:] == pytest.approx(-loop.tangential_force[:half], abs=1e-3 * SLIDING_N)


@pytest.mark.slow
def test_a_loop_in_partial_slip_is_followed_within_its_own_force(wires: solvers.ContactProblem) -> None:
    problem, amplitude = with_holder(wires, "rigid"), 0.0004
    state = solvers.first_quarter(problem, pressed(problem)[0], solvers.Drive(amplitude), INCREMENTS)
    _, fine = solvers.closed_cycle(problem, state, solvers.Drive(amplitude), 400)
    _, loop = solvers.closed_adaptive_cycle(problem, state, solvers.Drive(amplitude), INCREMENTS)
    largest = float(np.abs(fine.tangential_force).max())
    assert largest < 0.9 * SLIDING_N
    assert distance(loop, fine) <= 0.005 * largest
    assert loop.friction_work == pytest.approx(fine.friction_work, rel=0.02)


def test_no_step_is_refined_without_end_by_rough_force(
    wires: solvers.ContactProblem, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = with_holder(wires, "spring")
    state = solvers.first_quarter(problem, pressed(problem)[0], solvers.Drive(AMPLITUDE_mm), INCREMENTS)
    random = np.random.default_rng(3)
    true_force = solvers.adaptive_loop._force
    monkeypatch.setattr(
        solvers.adaptive_loop, "_force", lambda at: true_force(at) + 0.003 * SLIDING_N * random.normal()
    )
    _, loop = solvers.closed_adaptive_cycle(problem, state, solvers.Drive(AMPLITUDE_mm), INCREMENTS)
    assert len(loop.drive) < 600
