"""The step from one cycle jump to the next: the one place that says how a contact wears over many cycles at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from solvers import ContactProblem, ContactState, JumpController, JumpStep, take_step
from wirewear.simulation.cycler import Cycler, FrettingTest


class WearStepper(Protocol):
    """Takes cycle jumps.  first_jump: the size to try first, cycles."""

    @property
    def first_jump(self) -> float:
        """Cycles of the first jump to try."""

    def step(
        self,
        problem: ContactProblem,
        state: ContactState,
        done: float,
        wanted: float,
        milestones: tuple[float, ...],
        end: float,
        /,
    ) -> JumpStep[ContactState]:
        """One accepted jump from the state after `done` cycles, of about `wanted`, not beyond the next milestone.

        problem: on the meshes of now, without the effects of age.

        Raises:
            PatchLeftError: the contact left a patch; the run goes on with larger meshes, from the state given.
            SolverError: no jump could be taken.
        """


def wear_stepper(test: FrettingTest, cycler: Cycler, problem: ContactProblem) -> WearStepper:
    """How a test's contact wears: not at all, in jumps of a given size, or with the error of each jump controlled."""
    if problem.wear.none:
        return Unworn()
    if test.explicit_jump_cycles is not None:
        return ExplicitJumps(cycler, test.explicit_jump_cycles)
    return WholeCycles(cycler, JumpController(test.jump_tolerance))


def next_milestone(milestones: tuple[float, ...], done: float) -> float:
    """The first milestone after `done` cycles."""
    return min(milestone for milestone in milestones if milestone > done)


@dataclass(frozen=True)
class Unworn:
    """Nothing wears: the next milestone is a jump away."""

    first_jump: float = 1.0

    def step(
        self,
        _problem: ContactProblem,
        state: ContactState,
        done: float,
        wanted: float,
        milestones: tuple[float, ...],
        _end: float,
    ) -> JumpStep[ContactState]:
        """The same state at the next milestone."""
        return JumpStep(state, next_milestone(milestones, done) - done, 0.0, wanted)


@dataclass(frozen=True)
class ExplicitJumps:
    """Jumps of a given number of cycles, each one simulated cycle, without control of the error."""

    cycler: Cycler
    first_jump: float

    def step(
        self,
        problem: ContactProblem,
        state: ContactState,
        done: float,
        wanted: float,
        milestones: tuple[float, ...],
        _end: float,
    ) -> JumpStep[ContactState]:
        """One cycle that stands for the jump."""
        size = min(self.first_jump, next_milestone(milestones, done) - done)
        return JumpStep(self.cycler.worn(problem, state, done, size), size, 0.0, wanted)


@dataclass(frozen=True)
class WholeCycles:
    """Jumps in which all positions of a cycle wear the surface at the jump's end together; see `solvers.wear_step`."""

    cycler: Cycler
    controller: JumpController

    @property
    def first_jump(self) -> float:
        """That of the controller."""
        return self.controller.first_jump

    def step(
        self,
        problem: ContactProblem,
        state: ContactState,
        done: float,
        wanted: float,
        milestones: tuple[float, ...],
        end: float,
    ) -> JumpStep[ContactState]:
        """One accepted jump; see `solvers.jumps`."""
        attempt = self.cycler.wearing(problem, state, done)
        return take_step(self.controller, state, wanted, done, milestones, end, attempt)
