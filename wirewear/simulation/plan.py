"""A test as a run goes through it, with the motion of each of its blocks, and what all planned runs share.

The age of a test is its cycles and friction energy. A motion takes problems without the effects of age; `aged` adds
them.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

from solvers import ContactProblem, ContactState, Drive, WearState, unloaded_state
from wirewear.base.cache import RUN_CODE, Identity, added_code, identity_of
from wirewear.effects import Age, problem_with
from wirewear.simulation.control import HeldFigure, held_of
from wirewear.simulation.meshes import Meshes
from wirewear.simulation.near_zone import NearZone
from wirewear.simulation.problem import fresh_state, laws_of, problem_at
from wirewear.test import AnyStudy, LineStudy, Study
from wirewear.test.any_study import Of
from wirewear.test.conditions import Stop


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


@dataclass(frozen=True)
class FrettingTest:
    """A test as a run goes through it, for any kind of contact. motions: (last cycle, motion) of each block.
    milestones: cycles whose loop is measured, increasing to the test's end. jump_tolerance: relative error allowed to a
    cycle jump. explicit_jump_cycles: size of jumps without error control, None for jumps with it.
    """

    motions: tuple[tuple[float, Motion], ...]
    meshes: Meshes
    milestones: tuple[float, ...]
    jump_tolerance: float
    explicit_jump_cycles: float | None = None
    stop: Stop | None = None

    @property
    def cycles(self) -> float:
        return self.milestones[-1]

    @cached_property
    def stops(self) -> tuple[float, ...]:
        """Cycles that no jump passes over, increasing: milestones, and ends of motions."""
        return tuple(sorted({*self.milestones, *(end for end, _ in self.motions)}))

    def motion_at(self, done: float) -> Motion:
        """The motion of cycle `done`, the last one of a block included; the last motion beyond the test's end."""
        return next((motion for end, motion in self.motions if done <= end), self.motions[-1][1])

    def motion_after(self, done: float) -> Motion:
        """The motion of the cycles that follow cycle `done`."""
        return next((motion for end, motion in self.motions if done < end), self.motions[-1][1])


@dataclass(frozen=True)
class PlannedRun:
    """A study without variants at a fidelity, with what it takes to run it."""

    study: AnyStudy
    fidelity: str

    @property
    def computed(self) -> AnyStudy:
        """The study as it is computed: for a line contact, 1 mm of it."""
        return self.study

    @property
    def label(self) -> str:
        return str(self.study.variant_name or self.study.name)

    def identified(self, plan: Mapping[str, object]) -> Identity:
        """The identity of this run, equal for runs that give the same result; only an equal run can be resumed.
        plan: all that the result depends on besides study, fidelity and code.
        """
        study = self.study
        asked = {"study": study.resolved(), "variant": study.variant_name, "fidelity": self.fidelity}
        return identity_of(asked, RUN_CODE, {**plan, "added": added_code((*study.effects, *study.laws))})

    def tested(
        self,
        study: Of,
        motion: Callable[[Of], Motion],
        meshes: Meshes,
        milestones: tuple[float, ...],
        tolerance: float,
        explicit_jump_cycles: float | None = None,
    ) -> FrettingTest:
        """The test of `study` (the `computed` one) as `cycle_through` simulates it. motion: gives the motion of a block
        from the block's own study. milestones: cycles whose loop is measured. tolerance: relative error allowed to a
        jump. explicit_jump_cycles: size of jumps without error control, None for jumps with it.
        """
        stretches = study.driven.schedule.stretches
        motions = {own.block: motion(own.study) for own in stretches}
        ends = tuple((float(own.end), motions[own.block]) for own in stretches)
        return FrettingTest(ends, meshes, milestones, tolerance, explicit_jump_cycles, study.tables.stop)
