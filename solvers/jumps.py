"""Cycle jumps: how many cycles one step of wear stands for.

A step has two stages; the difference of their pressures, 0 to 1 of the load (`CycleJump.pressure_change`), is its
change, and its error is of second order in it. The change thus sets the size of the next step. So does the error of the
friction work that the step predicts at its end, against a cycle traced there. Milestones, the cycles to be recorded,
are met exactly. A step's size (`jump`) is a number of cycles; done is the number of cycles before the step.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from solvers.errors import NotConvergedError, SolverError

State = TypeVar("State")

_SAFETY = 0.9
_MOST_REJECTIONS = 12


@dataclass(frozen=True)
class JumpController:
    """Chooses the size of cycle jumps from their errors."""

    tolerance: float  #: Allowed change of a step, squared: the pressures' error is of that order.
    first_jump: float = 9.0  #: Size of the first step, and a size always allowed later.
    largest_growth: float = 3.0  #: Largest ratio of the sizes of a step and the one before.
    largest_share: float = 1.0  #: Largest size of a step over the cycles already done.
    #: A step is never cut below this share of the cycles already done, so that a noisy estimate cannot stall the run.
    least_share: float = 0.02

    def accepted(self, change: float, jump: float, done: float) -> bool:
        """True if a step of size `jump` with this change is accurate enough (change² at most twice the tolerance), or
        so short that it must not be cut.
        """
        # A step that was taken is kept unless its error is beyond the tolerance by this factor.
        return change**2 <= 2.0 * self.tolerance or jump <= max(1.0, self.least_share * done)

    def following(self, change: float, jump: float, done: float) -> float:
        """Size of the next step after one of size `jump` with this change; `done`: the number of cycles at its end."""
        wanted = _SAFETY * self.tolerance**0.5 / max(change, 1e-300)
        grown = float(jump * min(max(wanted, 0.2), self.largest_growth))
        return min(grown, max(self.largest_share * done, self.first_jump))

    def limited(self, jump: float, done: float, milestones: tuple[float, ...], end: float) -> float:
        """The size adapted to the next of `milestones` and `end`: stretched by at most a quarter to meet it, else at
        most half of the way to it, so that no tiny step is left.
        """
        ahead = min((m for m in (*milestones, end) if m > done + 1e-9 * max(done, 1.0)), default=end) - done
        if jump >= 0.8 * ahead:
            return ahead
        return min(jump, 0.5 * ahead)


def change_by_work(predicted_mJ: float, traced_mJ: float, cycles: float, energy_mJ: float) -> float:
    """The change of pressures that is equivalent to the error of a step's friction work, for `JumpController`.

    predicted_mJ, traced_mJ: friction work of the cycle after a step of `cycles` cycles, by the step and by a cycle
    traced on the worn surfaces.  energy_mJ: friction energy of the whole run so far.

    The difference grows linearly along the step, so the step's energy misses half of it per cycle.
    """
    missed = 0.5 * cycles * abs(traced_mJ - predicted_mJ)
    # The share of all friction energy that a step may miss, over the tolerance.
    return float(missed / (0.1 * max(energy_mJ, 1e-300))) ** 0.5 if missed else 0.0


@dataclass(frozen=True)
class JumpStep(Generic[State]):
    """An accepted step: the state after it, its size in cycles, its change, and the size to try next."""

    state: State
    jump: float
    change: float
    next_jump: float


def take_step(
    controller: JumpController,
    state: State,
    jump: float,
    done: float,
    milestones: tuple[float, ...],
    end: float,
    attempt: Callable[[State, float, float], tuple[State, float]],
) -> JumpStep[State]:
    """Take one accepted step from `state` after `done` cycles.

    jump: size to try first. milestones, end: cycles that no step passes over. attempt(state, done, size): tries a step,
    returns the state after it and its change. A step that does not converge is cut. Raises SolverError after 12
    rejections, NotConvergedError if a single cycle does not converge.
    """
    wanted, growth = jump, controller.largest_growth
    for _ in range(_MOST_REJECTIONS):
        size = controller.limited(wanted, done, milestones, end)
        try:
            after, change = attempt(state, done, size)
        except NotConvergedError:
            if size <= 1.0:
                raise
            # The next steps approach the size that failed with care.
            wanted, growth = 0.35 * size, 1.5
            continue
        following = min(controller.following(change, size, done + size), growth * size)
        if controller.accepted(change, size, done):
            # A step shortened for a milestone must not slow down the following ones.
            next_jump = max(following, min(wanted, controller.largest_growth * size)) if size < wanted else following
            return JumpStep(after, size, change, next_jump)
        # Below 0.8 of the rejected size, so that a milestone cannot stretch the step to that size again.
        wanted = min(following, 0.75 * size)
    raise SolverError(
        f"the cycle jump after cycle {done:g} was rejected {_MOST_REJECTIONS} times; loosen jump_tolerance"
    )
