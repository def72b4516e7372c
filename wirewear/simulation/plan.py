"""What all planned runs share."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from wirewear.base.cache import RUN_CODE, Identity, added_code, identity_of
from wirewear.simulation.cycler import FrettingTest, Motion
from wirewear.simulation.meshes import Meshes
from wirewear.test import AnyStudy
from wirewear.test.any_study import Of


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
