"""The motion of a contact in a block of cycles, and how its problem follows from the block and the test's age.

The age of a test is its cycles and friction energy. Problems are passed without the effects of age, which `aged` adds.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace

from solvers import ContactProblem, ContactState, Drive, WearState, unloaded_state
from wirewear.effects import Age, problem_with
from wirewear.simulation.control import HeldFigure, held_of
from wirewear.simulation.near_zone import NearZone
from wirewear.simulation.problem import fresh_state, laws_of, problem_at
from wirewear.test import LineStudy, Study


@dataclass(frozen=True)
class Motion(ABC):
    """The motion of any kind of contact in a block.

    increments: number in a cycle whose loop is measured; with follows_force more are made where the force turns
    quickly. wear_increments: number in a cycle that is only worn by. held: the quantity that the drive holds, None for
    its amplitude.
    """

    drive: Drive
    increments: int
    wear_increments: int
    follows_force: bool
    held: HeldFigure | None = None

    def fresh(self, problem: ContactProblem) -> ContactState:
        """The state of bodies that just touch."""
        return unloaded_state(problem)

    @abstractmethod
    def aged(self, problem: ContactProblem, age: Age) -> ContactProblem:
        """The problem with the effects that it has at an age."""

    @abstractmethod
    def under(self, problem: ContactProblem) -> ContactProblem:
        """The problem with load, rig and laws of the block."""

    def slid(self, _problem: ContactProblem, _wear: WearState) -> WearState | None:
        """The wear state with the permanent depths that sliding leaves in metal that flows; None for elastic bodies."""
        return None


@dataclass(frozen=True, kw_only=True)
class PointMotion(Motion):
    """Motion of a contact at a point. study: the block's own. near: the metal about the contact, None for elastic."""

    study: Study
    near: NearZone | None

    @classmethod
    def of(cls, study: Study, near: NearZone | None, increments: tuple[int, int], fidelity: str) -> "PointMotion":
        """The motion of a block from its own study. increments: in a cycle that is measured, and in one that wears."""
        follows = study.fidelity(fidelity).increments_per_cycle is None
        return cls(study.drive, *increments, follows, held_of(study), study=study, near=near)

    def fresh(self, problem: ContactProblem) -> ContactState:
        return fresh_state(problem, self.study, self.near)

    def aged(self, problem: ContactProblem, age: Age) -> ContactProblem:
        return problem_at(problem, self.study, age)

    def under(self, problem: ContactProblem) -> ContactProblem:
        return replace(problem, **laws_of(self.study))

    def slid(self, problem: ContactProblem, wear: WearState) -> WearState | None:
        if self.near is None or self.near.sliding is self.near.pressing:
            return None
        return self.near.slid(problem, wear)


@dataclass(frozen=True, kw_only=True)
class LineMotion(Motion):
    """Motion of a line contact of 1 mm length. study: the block's own, of that length."""

    study: LineStudy

    @classmethod
    def of(cls, study: LineStudy, increments: int) -> "LineMotion":
        """The motion of a block from its own study, with this many increments in every cycle."""
        follows = study.mesh.increments_per_cycle is None
        return cls(study.drive, increments, increments, follows, held_of(study), study=study)

    def aged(self, problem: ContactProblem, age: Age) -> ContactProblem:
        return problem_with(problem, self.study.effects, age)

    def under(self, problem: ContactProblem) -> ContactProblem:
        return replace(problem, **laws_of(self.study))
