"""Free play of the holder: a dead band in series with its springs, as the loop of the whole contact shows it."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from solvers.contact import ContactProblem
from solvers.contact_state import ContactState, IncrementReport
from solvers.errors import SolverError
from solvers.holder_measurement import measured_holder
from tests.bodies import FRICTION, LOAD_N, AMPLITUDE_mm, RIG_N_per_mm, crossed_wires, driven, pressed

COARSE_mm = 0.010
PLAY_mm = 0.006
SLIDING_N = FRICTION * LOAD_N
INCREMENTS = 40
LOOP = AMPLITUDE_mm * np.cos(2.0 * np.pi * np.arange(1, INCREMENTS + 1) / INCREMENTS)


@dataclass
class Run:
    states: list[ContactState]
    reports: list[list[IncrementReport]]

    @property
    def force(self) -> np.ndarray:
        return np.array([pieces[-1].tangential_force for pieces in self.reports])

    @property
    def holder_x(self) -> np.ndarray:
        return np.array([state.holder_x for state in self.states])

    @property
    def energy(self) -> float:
        return sum(piece.friction_work for pieces in self.reports for piece in pieces)


def loop(problem: ContactProblem) -> Run:
    """A closed loop from +amplitude and back, after the way there."""
    started, _ = driven(problem, pressed(problem)[0], AMPLITUDE_mm * np.sin(0.5 * np.pi * np.arange(1, 6) / 5))
    return Run(*driven(problem, started[-1], LOOP))


@pytest.fixture(scope="module")
def spring() -> ContactProblem:
    return crossed_wires(COARSE_mm, long_patch=True, rig_N_per_mm=RIG_N_per_mm)


def with_play(problem: ContactProblem, **changes: float) -> ContactProblem:
    return replace(problem, holder=replace(problem.holder, play_mm=PLAY_mm, **changes))


@pytest.fixture(scope="module")
def without(spring: ContactProblem) -> Run:
    return loop(spring)


@pytest.fixture(scope="module")
def loose(spring: ContactProblem) -> Run:
    return loop(with_play(spring))


def test_play_takes_twice_its_width_times_the_sliding_force_from_the_energy(without: Run, loose: Run) -> None:
    assert without.energy - loose.energy == pytest.approx(2.0 * PLAY_mm * SLIDING_N, rel=0.03)
    assert np.abs(loose.force).max() == pytest.approx(np.abs(without.force).max(), rel=1e-3)


def test_the_holder_moves_by_spring_and_half_the_play_and_floats_without_force(loose: Run) -> None:
    floating = np.abs(loose.force) < 1e-6 * SLIDING_N
    place = loose.holder_x - loose.force / RIG_N_per_mm
    assert np.abs(place).max() <= 0.5 * PLAY_mm * (1.0 + 1e-9)
    assert place[~floating] == pytest.approx(0.5 * PLAY_mm * np.sign(loose.force[~floating]), abs=1e-9)
    assert max(piece.force_error for pieces in loose.reports for piece in pieces) < 1e-9


def test_after_a_reversal_the_loop_has_a_shelf_of_the_width_of_the_play(spring: ContactProblem) -> None:
    problem = with_play(spring)
    start, _ = driven(problem, pressed(problem)[0], AMPLITUDE_mm * np.sin(0.5 * np.pi * np.arange(1, 6) / 5))
    drives = np.asarray(AMPLITUDE_mm - 0.001 * np.arange(1, 22), dtype=np.float64)
    states, reports = driven(problem, start[-1], drives)
    force = np.array([pieces[-1].tangential_force for pieces in reports])
    floating = np.abs(force) < 1e-6 * SLIDING_N
    assert floating.sum() in (5, 6, 7)
    holder = np.array([state.holder_x for state in states])
    # The wires stick and the holder travels with the drive.
    assert np.diff(holder[floating]) == pytest.approx(np.diff(drives[floating]), rel=1e-3)
    # Straight lines through the elastic branches on either side meet zero force at the shelf's ends.
    ends = []
    for branch in (force > 0.25 * SLIDING_N, force < -0.25 * SLIDING_N):
        near = np.flatnonzero(branch)
        near = near[-3:] if force[near[0]] > 0.0 else near[:3]
        ends.append(np.polyval(np.polyfit(force[near], drives[near], 1), 0.0))
    assert ends[0] - ends[1] == pytest.approx(PLAY_mm, rel=0.1)


def test_the_loop_gives_back_every_element_of_the_holder(spring: ContactProblem) -> None:
    arm = 9.0
    problem = with_play(spring, rotational_compliance_rad_per_N_mm=1.0 / (400.0 * arm**2), pivot_height_mm=arm)
    found = measured_holder(problem, loop(problem).states)
    assert found.tangential_stiffness_N_per_mm == pytest.approx(RIG_N_per_mm, rel=1e-6)
    assert found.rotational_stiffness_N_mm_per_rad == pytest.approx(400.0 * arm**2, rel=1e-6)
    assert found.play_mm == pytest.approx(PLAY_mm, rel=1e-6)
    series = 1.0 / (1.0 / RIG_N_per_mm + 1.0 / 400.0)
    assert found.contact_stiffness_N_per_mm == pytest.approx(series, rel=0.02)


def test_play_within_which_the_whole_stroke_fits_carries_no_force(spring: ContactProblem) -> None:
    problem = replace(spring, holder=replace(spring.holder, play_mm=3.0 * AMPLITUDE_mm))
    run = loop(problem)
    assert np.abs(run.force).max() < 1e-6 * SLIDING_N
    assert run.energy == pytest.approx(0.0, abs=1e-9)
    with pytest.raises(SolverError, match="forces in both directions"):
        measured_holder(problem, run.states)
