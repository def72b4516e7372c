"""Loops with increments where the force bends, against loops of 400 increments."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from solvers import (
    ContactProblem,
    CycleTrace,
    Holder,
    adaptive_loop,
    closed_adaptive_cycle,
    closed_cycle,
    first_quarter,
)
from tests.bodies import FRICTION, LOAD_N, AMPLITUDE_mm, RIG_N_per_mm, crossed_wires, pressed
from wirewear.loops.area import enclosed_area

Array = NDArray[np.float64]

INCREMENTS = 32
SLIDING_N = FRICTION * LOAD_N
PLAY_mm = 0.006


def stroke(trace: CycleTrace, *, falling: bool) -> tuple[Array, Array]:
    """Drive and force of one stroke, from the end before it, in the order of increasing drive."""
    drive, force = (np.append(values[-1], values) for values in (trace.drive, trace.tangential_force))
    part = np.flatnonzero((np.diff(drive) < 0.0) == falling)
    chosen = np.append(part[0], part + 1)
    order = np.argsort(drive[chosen])
    return drive[chosen][order], force[chosen][order]


def distance(coarse: CycleTrace, fine: CycleTrace) -> float:
    """Largest distance of the fine loop's force from straight lines between the coarse one's increments, N."""
    pairs = ((stroke(coarse, falling=falling), stroke(fine, falling=falling)) for falling in (True, False))
    return max(float(np.abs(np.interp(x, *line) - q).max()) for line, (x, q) in pairs)


@pytest.fixture(scope="module")
def wires() -> ContactProblem:
    return crossed_wires(0.010, long_patch=True, rig_N_per_mm=RIG_N_per_mm)


def with_holder(wires: ContactProblem, name: str) -> ContactProblem:
    spring = wires.holder
    holders = {"rigid": Holder(LOAD_N), "spring": spring, "free play": replace(spring, play_mm=PLAY_mm)}
    return replace(wires, holder=holders[name])


@pytest.mark.parametrize("holder", ["rigid", "spring", "free play"])
def test_straight_lines_between_increments_follow_a_loop_of_400(wires: ContactProblem, holder: str) -> None:
    problem = with_holder(wires, holder)
    state = first_quarter(problem, pressed(problem)[0], AMPLITUDE_mm, INCREMENTS)
    _, fine = closed_cycle(problem, state, AMPLITUDE_mm, 400)
    _, loop = closed_adaptive_cycle(problem, state, AMPLITUDE_mm, INCREMENTS)
    assert distance(loop, fine) <= 0.005 * SLIDING_N
    assert len(loop.drive) <= 120
    # As many increments on a cosine do not.
    count = 4 * (len(loop.drive) // 4)
    _, cosine = closed_cycle(problem, state, AMPLITUDE_mm, count)
    assert distance(cosine, fine) > distance(loop, fine)
    area = abs(enclosed_area(loop.drive, loop.tangential_force))
    assert loop.friction_work == pytest.approx(area, rel=1e-3)
    assert loop.friction_work == pytest.approx(fine.friction_work, rel=5e-4)
    # The way back is the mirror image of the way out.
    half = len(loop.drive) // 2
    assert loop.drive[half:] == pytest.approx(-loop.drive[:half], abs=0.0)
    assert loop.tangential_force[half:] == pytest.approx(-loop.tangential_force[:half], abs=1e-3 * SLIDING_N)


@pytest.mark.slow
def test_a_loop_in_partial_slip_is_followed_within_its_own_force(wires: ContactProblem) -> None:
    problem, amplitude = with_holder(wires, "rigid"), 0.0004
    state = first_quarter(problem, pressed(problem)[0], amplitude, INCREMENTS)
    _, fine = closed_cycle(problem, state, amplitude, 400)
    _, loop = closed_adaptive_cycle(problem, state, amplitude, INCREMENTS)
    largest = float(np.abs(fine.tangential_force).max())
    assert largest < 0.9 * SLIDING_N
    assert distance(loop, fine) <= 0.005 * largest
    assert loop.friction_work == pytest.approx(fine.friction_work, rel=0.02)


@pytest.mark.parametrize("stroke_mm", [3.3e-4, 5.0e-4])
def test_the_area_of_a_thin_loop_is_its_friction_work(wires: ContactProblem, stroke_mm: float) -> None:
    problem = with_holder(wires, "rigid")
    state = first_quarter(problem, pressed(problem)[0], stroke_mm, INCREMENTS)
    _, loop = closed_adaptive_cycle(problem, state, stroke_mm, INCREMENTS)
    force = float(np.abs(loop.tangential_force).max())
    assert 0.0 < loop.friction_work < 0.1 * 4.0 * stroke_mm * force
    assert abs(enclosed_area(loop.drive, loop.tangential_force)) == pytest.approx(loop.friction_work, rel=4e-4)


def test_phases_are_those_of_a_cosine_and_mid_stroke_is_met(wires: ContactProblem) -> None:
    problem = with_holder(wires, "spring")
    state = first_quarter(problem, pressed(problem)[0], AMPLITUDE_mm, INCREMENTS)
    end, loop = closed_adaptive_cycle(problem, state, AMPLITUDE_mm, INCREMENTS)
    assert loop.drive == pytest.approx(AMPLITUDE_mm * np.cos(2.0 * np.pi * loop.phase), abs=1e-9)
    assert (loop.drive == 0.0).sum() == 2
    assert end.drive == loop.drive[-1] == -AMPLITUDE_mm
    assert loop.middle.drive == 0.0
    rising = [state for state, phase in zip(loop.states, loop.phase, strict=True) if phase == pytest.approx(0.75)]
    assert loop.middle is rising[0]
    assert np.abs(np.diff(loop.drive)).max() <= 2.0 * np.pi * AMPLITUDE_mm / INCREMENTS * 1.25


def test_no_step_is_refined_without_end_where_the_force_is_rough(
    wires: ContactProblem, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = with_holder(wires, "spring")
    state = first_quarter(problem, pressed(problem)[0], AMPLITUDE_mm, INCREMENTS)
    random = np.random.default_rng(3)
    true_force = adaptive_loop._force
    monkeypatch.setattr(adaptive_loop, "_force", lambda at: true_force(at) + 0.003 * SLIDING_N * random.normal())
    _, loop = closed_adaptive_cycle(problem, state, AMPLITUDE_mm, INCREMENTS)
    assert len(loop.drive) < 600
