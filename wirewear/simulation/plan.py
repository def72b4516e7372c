"""A test as a run goes through it, and what all planned runs share."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

from wirewear.base.cache import RUN_CODE, Identity, added_code, identity_of
from wirewear.simulation.meshes import Meshes
from wirewear.simulation.motion import Motion
from wirewear.test import AnyStudy
from wirewear.test.any_study import Of
from wirewear.test.conditions import Stop


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
