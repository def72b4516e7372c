"""Cycle jumps: how many cycles one simulated cycle stands for.

A step of n cycles is taken once as a whole and once as two halves (step doubling). Their difference estimates the
error, sets the next step, and is extrapolated away, which makes the jumps second order (Hairer, Norsett & Wanner,
Solving Ordinary Differential Equations I, II.4). Milestones, the cycles to be logged, are hit exactly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from solvers.errors import NotConvergedError, SolverError

State = TypeVar("State")

_SAFETY = 0.9
_MOST_REJECTIONS = 12
# Of a step that did not converge, what is tried next.
_CUT_BACK = 0.35
_GROWTH_AFTER_FAILURE = 1.5


@dataclass(frozen=True)
class JumpController:
    """Chooses the size of cycle jumps.

    tolerance: allowed estimated error of a step relative to what has been accumulated.  first_jump: cycles of the
    first step.  largest_growth: of one step over the one before.  least_share: a step is never cut below this share of
    the cycles already done, so that a noisy estimate cannot stall the run.
    """

    tolerance: float
    first_jump: float = 9.0
    largest_growth: float = 4.0
    least_share: float = 0.02

    def __post_init__(self) -> None:
        if not 0.0 < self.tolerance < 1.0:
            raise SolverError(f"the tolerance of cycle jumps must lie between 0 and 1, but is {self.tolerance}")
        if self.first_jump <= 0.0 or self.largest_growth <= 1.0 or self.least_share < 0.0:
            raise SolverError("cycle jumps need a positive first jump and a largest growth above 1")

    def accepted(self, error: float, jump: float, done: float) -> bool:
        """Whether a step with this estimated error may stand."""
        return error <= self.tolerance or jump <= max(1.0, self.least_share * done)

    def following(self, error: float, jump: float) -> float:
        """The step to try after one of this size and error; the local error is of second order."""
        wanted = _SAFETY * (self.tolerance / max(error, 1e-300)) ** 0.5
        return float(jump * min(max(wanted, 0.2), self.largest_growth))

    def limited(self, jump: float, done: float, milestones: tuple[float, ...], end: float) -> float:
        """The step adapted to meet the next milestone, stretched by at most a quarter, without leaving a tiny rest."""
        ahead = min((m for m in (*milestones, end) if m > done + 1e-9 * max(done, 1.0)), default=end) - done
        if jump >= 0.8 * ahead:
            return ahead
        return min(jump, 0.5 * ahead)


@dataclass(frozen=True)
class JumpStep(Generic[State]):
    """An accepted step: the state after it, its size, its estimated error, the size to try next."""

    state: State
    jump: float
    error: float
    next_jump: float


def take_step(
    controller: JumpController,
    state: State,
    jump: float,
    done: float,
    milestones: tuple[float, ...],
    end: float,
    cycle: Callable[[State, float, float], State],
    compare: Callable[[State, State], float],
    extrapolate: Callable[[State, State], State],
) -> JumpStep[State]:
    """One accepted step from `state` after `done` cycles.

    cycle(state, done, n): simulates one cycle that stands for n after `done`.
    compare(whole, halves): relative difference.
    extrapolate(whole, halves): their second-order combination. SolverError when steps are rejected without end.

    A step in which the contact does not converge is cut: where a node's wear over a jump would unload it, stick and
    slip may both, or neither, satisfy the equations.
    """
    wanted, growth = jump, controller.largest_growth
    for _ in range(_MOST_REJECTIONS):
        size = controller.limited(wanted, done, milestones, end)
        try:
            whole = cycle(state, done, size)
            middle = cycle(state, done, 0.5 * size)
            halves = cycle(middle, done + 0.5 * size, 0.5 * size)
        except NotConvergedError:
            if size <= 1.0:
                raise
            # The next steps approach the size that failed with care.
            wanted, growth = _CUT_BACK * size, _GROWTH_AFTER_FAILURE
            continue
        error = compare(whole, halves)
        following = min(controller.following(error, size), growth * size)
        if controller.accepted(error, size, done):
            # A step shortened for a milestone must not slow down the following ones.
            next_jump = max(following, min(wanted, controller.largest_growth * size)) if size < wanted else following
            return JumpStep(extrapolate(whole, halves), size, error, next_jump)
        # Below 0.8 of the rejected size, so that a milestone cannot stretch the step to that size again.
        wanted = min(following, 0.75 * size)
    raise SolverError(
        f"the cycle jump after cycle {done:g} was rejected {_MOST_REJECTIONS} times; loosen jump_tolerance"
    )
