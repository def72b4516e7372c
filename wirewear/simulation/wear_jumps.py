"""Cycle jumps of a run: without wear, of a stated size, or as large as their error allows (`solvers.wear_step`).

Problems are passed on the current meshes, without the effects of the test's age.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import solvers
from solvers import ContactProblem, ContactState, JumpController, JumpStep
from wirewear.effects import Age
from wirewear.simulation.cycler import Cycler, Traced
from wirewear.simulation.plan import FrettingTest


class WearJumps(ABC):
    """How a run jumps over cycles. first_jump: size of the first jump in cycles."""

    first_jump: float

    @abstractmethod
    def step(
        self,
        problem: ContactProblem,
        state: ContactState,
        done: float,
        wanted: float,
        milestones: tuple[float, ...],
        end: float,
    ) -> JumpStep[ContactState]:
        """The jump from `state`, after `done` cycles. wanted: size to try first. milestones, end: cycles that are not
        passed over. Raises PatchLeftError if the contact left a patch (the run goes on with larger meshes from the
        state before), and SolverError if no jump could be taken.
        """


def wear_jumps(test: FrettingTest, cycler: Cycler, problem: ContactProblem) -> WearJumps:
    """How a test's cycles are jumped over: without wear, by the stated size, or controlled. problem: under the present
    motion.
    """
    if problem.unchanging:
        return NoWear()
    if test.explicit_jump_cycles is not None:
        return StatedJumps(cycler, test.explicit_jump_cycles)
    return ControlledJumps(cycler, JumpController(test.jump_tolerance))


class NoWear(WearJumps):
    """Jumps from milestone to milestone where nothing wears."""

    first_jump = 1.0

    def step(
        self,
        problem: ContactProblem,  # noqa: ARG002
        state: ContactState,
        done: float,
        wanted: float,
        milestones: tuple[float, ...],
        end: float,  # noqa: ARG002
    ) -> JumpStep[ContactState]:
        return JumpStep(state, min(one for one in milestones if one > done) - done, 0.0, wanted)


@dataclass(frozen=True)
class StatedJumps(WearJumps):
    """Jumps of `first_jump` cycles, each by one simulated cycle that stands for all; shorter before a milestone."""

    cycler: Cycler
    first_jump: float

    def step(
        self,
        problem: ContactProblem,
        state: ContactState,
        done: float,
        wanted: float,
        milestones: tuple[float, ...],
        end: float,  # noqa: ARG002
    ) -> JumpStep[ContactState]:
        jump = min(self.first_jump, min(one for one in milestones if one > done) - done)
        return JumpStep(self.cycler.worn(problem, state, done, jump), jump, 0.0, wanted)


class ControlledJumps(WearJumps):
    """Jumps whose error `controller` bounds."""

    def __init__(self, cycler: Cycler, controller: JumpController) -> None:
        self.cycler, self.controller, self.first_jump = cycler, controller, controller.first_jump

    def step(
        self,
        problem: ContactProblem,
        state: ContactState,
        done: float,
        wanted: float,
        milestones: tuple[float, ...],
        end: float,
    ) -> JumpStep[ContactState]:
        trials = JumpTrials(self.cycler, problem, self.cycler.traced(problem, state, done))
        return solvers.take_step(self.controller, state, wanted, done, milestones, end, trials.tried)


class JumpTrials:
    """Jumps of several sizes tried from the end of one cycle, which was traced without wear."""

    def __init__(self, cycler: Cycler, problem: ContactProblem, start: Traced) -> None:
        self.cycler, self.problem, self.start = cycler, problem, start
        self._uncounted: Traced | None = None
        # A cycle that judges a jump, or leads to a loop, is that from which the next one starts: counted here, a run
        # that is resumed between both, and traces it again, counts as one that is not.
        cycler.count(start)

    def tried(self, _state: ContactState, done: float, cycles: float) -> tuple[ContactState, float]:
        """(state after a jump of `cycles` cycles after `done` ones, relative change of the pressures)."""
        cycler, start = self.cycler, self.start
        if self._uncounted is not None:
            cycler.count(self._uncounted)
            self._uncounted = None
        jump = solvers.jump_cycles(self._problem_at, start.start, start.trace, start.symmetry, done, cycles)
        cycler.guide, cycler.friction_work_mJ = jump.guide, jump.friction_work
        if not jump.uncertain:
            return jump.state, jump.pressure_change
        # What sticks and how far the rest slides is known of the cycle before the jump: the one after it shows what
        # came of that, and is of no use if the jump is rejected.
        after = self._uncounted = cycler.traced(self.problem, jump.state, done + cycles)
        cycler.friction_work_mJ = after.work_mJ
        missed = solvers.change_by_work(jump.friction_work, after.work_mJ, cycles, jump.state.wear.energy_mJ)
        return jump.state, max(jump.pressure_change, missed)

    def _problem_at(self, cycle: float, energy_mJ: float) -> ContactProblem:
        return self.cycler.motion.aged(self.problem, Age(cycle, 1e-3 * energy_mJ))
