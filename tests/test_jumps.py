"""The cycle-jump controller, on ordinary differential equations without any contact."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from solvers import JumpController, NotConvergedError, SolverError, take_step


def implicit_decay(state: float, done: float, cycles: float) -> float:
    """One implicit Euler step of y' = -y / 50."""
    return state / (1.0 + cycles / 50.0)


def integrate(tolerance: float, end: float, milestones: tuple[float, ...] = ()) -> tuple[float, list[float]]:
    controller = JumpController(tolerance, first_jump=5.0)
    state, done, jump = 1.0, 0.0, controller.first_jump
    visited = []
    while done < end:
        step = take_step(
            controller,
            state,
            jump,
            done,
            milestones,
            end,
            implicit_decay,
            lambda whole, halves: abs(whole - halves) / abs(halves),
            lambda whole, halves: 2.0 * halves - whole,
        )
        state, jump = step.state, step.next_jump
        done += step.jump
        visited.append(done)
    return state, visited


def test_tighter_tolerance_brings_the_solution_closer_to_the_exact_one() -> None:
    exact = math.exp(-4.0)
    coarse, fine, finest = (abs(integrate(tolerance, 200.0)[0] - exact) for tolerance in (0.03, 0.003, 0.0003))
    assert finest < 0.3 * fine < 0.1 * coarse


def test_jumps_are_second_order() -> None:
    # The number of steps doubles when the tolerance falls to a quarter; the error then falls to a quarter too.
    exact = math.exp(-4.0)
    (first, first_steps), (second, second_steps) = integrate(0.004, 200.0), integrate(0.001, 200.0)
    order = math.log(abs(first - exact) / abs(second - exact)) / math.log(len(second_steps) / len(first_steps))
    assert 1.6 < order < 2.6


@given(st.lists(st.floats(1.0, 180.0), min_size=1, max_size=6, unique=True), st.floats(0.003, 0.2))
def test_every_milestone_is_met_exactly(milestones: list[float], tolerance: float) -> None:
    _, visited = integrate(tolerance, 200.0, tuple(sorted(milestones)))
    for milestone in [*milestones, 200.0]:
        assert min(abs(done - milestone) for done in visited) < 1e-6


def test_smooth_solutions_let_jumps_grow_no_faster_than_allowed() -> None:
    controller = JumpController(0.5, largest_growth=3.0)
    assert controller.following(1e-12, 10.0) == pytest.approx(30.0)


def test_large_errors_cut_the_jump() -> None:
    controller = JumpController(0.01)
    assert not controller.accepted(0.04, 100.0, 10.0)
    assert controller.following(0.04, 100.0) == pytest.approx(45.0)


def test_a_jump_in_which_the_contact_does_not_converge_is_cut() -> None:
    tried = []

    def fragile(state: float, done: float, cycles: float) -> float:
        tried.append(cycles)
        if cycles > 7.0:
            raise NotConvergedError("flickers")
        return implicit_decay(state, done, cycles)

    arguments = (lambda _whole, _halves: 1e-9, lambda _whole, halves: halves)
    step = take_step(JumpController(0.1), 1.0, 40.0, 0.0, (), 1000.0, fragile, *arguments)
    assert 2.0 < step.jump <= 7.0
    assert step.next_jump <= 1.5 * step.jump
    assert tried[0] == 40.0
    with pytest.raises(NotConvergedError, match="flickers"):
        take_step(JumpController(0.1), 1.0, 1.0, 0.0, (), 1000.0, lambda *_: fragile(1.0, 0.0, 9.0), *arguments)


def test_jumps_that_are_rejected_without_end_are_an_error() -> None:
    controller = JumpController(1e-6, least_share=0.0)
    with pytest.raises(SolverError, match="was rejected"):
        take_step(controller, 1.0, 1e9, 1.0, (), 1e12, lambda s, _done, _n: s, lambda *_: 1.0, lambda _, b: b)


@pytest.mark.parametrize("tolerance", [0.0, 1.0, -0.1])
def test_senseless_tolerances_are_refused(tolerance: float) -> None:
    with pytest.raises(SolverError, match="tolerance of cycle jumps"):
        JumpController(tolerance)
