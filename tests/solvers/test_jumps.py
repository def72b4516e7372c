"""Jumps over cycles: their error on plain equations, and of a core that shrinks on real bodies."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from threadpoolctl import threadpool_limits

import solvers
from tests.bodies import crossed_wires
from tests.solvers.wear_jumps import INCREMENTS, RATES, at_the_end
from wirewear.effects import Age
from wirewear.simulation.cycler import Cycler
from wirewear.simulation.plan import Motion
from wirewear.simulation.statistics import Tally
from wirewear.simulation.wear_jumps import ControlledJumps

STAGE = 1.0 - 0.5**0.5  # Alexander's method, as the wear step takes it.


def implicit_decay(state: float, done: float, cycles: float) -> tuple[float, float]:
    """Two implicit stages of y' = -y / 50, and by how much they differ."""
    first = state / (1.0 + STAGE * cycles / 50.0)
    last = (state - (1.0 - STAGE) * cycles / 50.0 * first) / (1.0 + STAGE * cycles / 50.0)
    return last, abs(last - first) / (abs(last) + abs(first))


def integrate(tolerance: float, end: float, milestones: tuple[float, ...] = ()) -> tuple[float, list[float]]:
    controller = solvers.JumpController(tolerance, first_jump=1.0)
    state, done, jump = 1.0, 0.0, controller.first_jump
    visited = []
    while done < end:
        step = solvers.take_step(controller, state, jump, done, milestones, end, implicit_decay)
        state, jump = step.state, step.next_jump
        done += step.jump
        visited.append(done)
    return state, visited


def test_jumps_are_second_order() -> None:
    # The number of steps doubles when the tolerance falls to a quarter; the error then falls to a quarter too.
    exact = math.exp(-4.0)
    (first, first_steps), (second, second_steps) = integrate(0.0004, 200.0), integrate(0.0001, 200.0)
    order = math.log(abs(first - exact) / abs(second - exact)) / math.log(len(second_steps) / len(first_steps))
    assert 1.6 < order < 2.6


@given(st.lists(st.floats(1.0, 180.0), min_size=1, max_size=6, unique=True), st.floats(0.003, 0.2))
def test_every_milestone_is_met_exactly(milestones: list[float], tolerance: float) -> None:
    _, visited = integrate(tolerance, 200.0, tuple(sorted(milestones)))
    for milestone in [*milestones, 200.0]:
        assert min(abs(done - milestone) for done in visited) < 1e-6


def test_a_jump_in_which_the_contact_does_not_converge_is_cut() -> None:
    tried = []

    def fragile(state: float, done: float, cycles: float) -> tuple[float, float]:
        tried.append(cycles)
        if cycles > 7.0:
            raise solvers.NotConvergedError("flickers")
        return implicit_decay(state, done, cycles)[0], 1e-9

    step = solvers.take_step(solvers.JumpController(0.1), 1.0, 40.0, 0.0, (), 1000.0, fragile)
    assert 2.0 < step.jump <= 7.0
    assert step.next_jump <= 9.0
    assert tried[0] == 40.0
    with pytest.raises(solvers.NotConvergedError, match="flickers"):
        solvers.take_step(solvers.JumpController(0.1), 1.0, 1.0, 0.0, (), 1000.0, lambda *_: fragile(1.0, 0.0, 9.0))


def test_jumps_that_are_rejected_without_end_are_an_error() -> None:
    controller = solvers.JumpController(1e-6, least_share=0.0)
    with pytest.raises(solvers.SolverError, match="was rejected"):
        solvers.take_step(controller, 1.0, 1e9, 1.0, (), 1e12, lambda state, _done, _n: (state, 1.0))


def test_friction_work_that_jumps_do_not_predict_keeps_the_energy_within_the_tolerance() -> None:
    # Work per cycle grows as 1 + N / 100, jumps predict that it stays.
    for tolerance in (0.1, 0.02):
        controller, energy, done, jump = solvers.JumpController(tolerance), 1.0, 1.0, 9.0
        steps = 0
        while done < 1e4:

            def attempt(state: float, before: float, cycles: float) -> tuple[float, float]:
                predicted, traced = 1.0 + before / 100.0, 1.0 + (before + cycles) / 100.0
                after = state + cycles * predicted
                return after, solvers.change_by_work(predicted, traced, cycles, after)

            step = solvers.take_step(controller, energy, jump, done, (), 1e4, attempt)
            energy, jump, done, steps = step.state, step.next_jump, done + step.jump, steps + 1
        assert energy == pytest.approx(1e4 + 0.5e8 / 100.0, rel=tolerance)
        assert steps < 40.0 / tolerance**0.5


RIG_N_per_mm = 20.0
STROKE_mm = 0.045
LAYER_mm = 1e-3
WEARS_IN_cycles = 1e3
CYCLES = 3e3
POWERS_OF_TEN = (10.0, 100.0, 1000.0)


class WearingIn(Motion):
    """Wires with a layer that wears in, which leaves the load to an ever smaller contact."""

    def aged(self, problem: solvers.ContactProblem, age: Age) -> solvers.ContactProblem:
        return replace(problem, layers=(solvers.RoughLayer(LAYER_mm * math.exp(-age.cycles / WEARS_IN_cycles)),))

    def under(self, problem: solvers.ContactProblem) -> solvers.ContactProblem:
        return problem


def course(largest_share: float, cycles: float = CYCLES, *, resumed: bool = False) -> tuple[float, float, float]:
    """Energy (mJ) that has worn after all cycles, how many were traced, and which share of the core still sticks.

    A run that is `resumed` after every jump knows nothing of a cycle traced before.
    """
    bare = crossed_wires(0.005, rig_N_per_mm=RIG_N_per_mm, wear=RATES)
    motion, tally = WearingIn(solvers.Drive(STROKE_mm), INCREMENTS, INCREMENTS, follows_force=False), Tally()

    def started() -> ControlledJumps:
        return ControlledJumps(
            Cycler(motion, tally, lambda *_: None), solvers.JumpController(0.1, largest_share=largest_share)
        )

    jumps = started()
    state = at_the_end(motion.aged(bare, Age(0.0, 0.0)), STROKE_mm)
    sticking, done, wanted = state.core.sum(), 1.0, jumps.first_jump
    with threadpool_limits(1, user_api="blas"):
        while done < cycles:
            step = jumps.step(bare, state, done, wanted, POWERS_OF_TEN, cycles)
            state, wanted, done = step.state, step.next_jump, done + step.jump
            jumps = started() if resumed else jumps
    return state.wear.energy_mJ, tally.counters.simulated_cycles, float(state.core.sum() / sticking)


@pytest.mark.slow
def test_a_core_that_shrinks_wears_by_few_judged_jumps_as_by_many_short_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    short, many, left = course(0.15)
    judged, few, _ = course(1.0)
    monkeypatch.setattr(solvers, "change_by_work", lambda *_: 0.0)
    unjudged, _, _ = course(1.0)
    assert left < 0.5
    assert few < 0.75 * many
    assert judged == pytest.approx(short, rel=0.03)
    assert short - unjudged > 3.0 * abs(short - judged)


@pytest.mark.slow
def test_a_run_resumed_after_every_jump_wears_as_much_and_counts_as_many_cycles() -> None:
    at_once, traced, _ = course(1.0, 100.0)
    resumed, again, _ = course(1.0, 100.0, resumed=True)
    # Other first guesses end within what Newton's method leaves of gaps, 1e-5.
    assert resumed == pytest.approx(at_once, rel=1e-5)
    assert again == traced
