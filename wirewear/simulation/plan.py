"""What one run is to do: resolution, meshes, and the cycles at which its loop is measured."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from wirewear.files.identity import RUN_CODE, Identity, added_code, identity_of
from wirewear.simulation.cycler import FrettingTest, Motion
from wirewear.simulation.discretisation import Discretisation, discretise
from wirewear.simulation.mesh_stages import mesh_stages, spare_stages
from wirewear.simulation.meshes import WireMeshes
from wirewear.simulation.problem import fresh_state, problem_at
from wirewear.study import Study
from wirewear.study.checked import default_loop_cycles
from wirewear.study.fidelity import WIRE_LEVELS, level_of


@dataclass(frozen=True)
class RunPlan:
    """A study without variants, or one of its variants, at a fidelity."""

    study: Study
    fidelity: str
    discretisation: Discretisation
    meshes: WireMeshes

    @classmethod
    def of(cls, study: Study, fidelity: str) -> RunPlan:
        """The plan of a study at a fidelity.

        Raises:
            StudyError: the study cannot be discretised.
        """
        discretisation = discretise(study, fidelity)
        stages = mesh_stages(study, fidelity, discretisation)
        spare = spare_stages(study, fidelity, discretisation, stages[-1])
        moves = level_of(WIRE_LEVELS, fidelity).move_nodes_at_stages or study.mesh.move_nodes_at_stages
        meshes = WireMeshes(study, discretisation.expected, stages, spare, moves)
        return cls(study, fidelity, discretisation, meshes)

    @property
    def label(self) -> str:
        """What the run is called beside others of its study."""
        return self.study.variant_name or self.study.name

    @property
    def test(self) -> FrettingTest:
        """The test as the run goes through it."""
        study, wear = self.study, self.study.wear
        motion = Motion(
            amplitude_mm=1e-3 * study.conditions.displacement_amplitude_um,
            increments=self.discretisation.increments_per_cycle,
            wear_increments=self.discretisation.increments_per_wear_cycle,
            follows_force=study.fidelity(self.fidelity).increments_per_cycle is None,
            fresh=lambda problem: fresh_state(problem, study),
            aged=lambda problem, age: problem_at(problem, study, age),
        )
        jump = wear.explicit_jump_cycles if wear else None
        return FrettingTest(motion, self.meshes, self.milestones, self.discretisation.jump_tolerance, jump)

    @property
    def logged_cycles(self) -> tuple[int, ...]:
        """Cycles whose loop and scars are recorded."""
        return self.study.log.loop_cycles or default_loop_cycles(self.study.conditions.cycles)

    @property
    def pressure_length_mm(self) -> float:
        """The diameter of the discs that mean pressures are over: the study's, or else that of the fresh contact.

        Worn wires touch in a band across the motion. Elements across the motion come near that diameter, so means over
        smaller discs would be those of single elements (docs/accuracy.md).
        """
        stated = self.study.log.pressure_length_um
        return 2.0 * self.discretisation.hertz.contact_radius_mm if stated is None else 1e-3 * stated

    @property
    def milestones(self) -> tuple[float, ...]:
        """Cycles at which the loop is measured: those to be logged, and of the series 1, 2, 5, 10, ... those apart from
        them by the level's ratio.
        """
        spacing, logged = level_of(WIRE_LEVELS, self.fidelity).loop_spacing, self.logged_cycles
        between = (
            cycle
            for cycle in default_loop_cycles(self.study.conditions.cycles)
            if all(max(cycle / other, other / cycle) >= spacing for other in logged)
        )
        return tuple(float(cycle) for cycle in sorted({*logged, *between, self.study.conditions.cycles}))

    @property
    def identity(self) -> Identity:
        """Equal for runs that give the same result; an interrupted run goes on only with its own."""
        study = self.study
        asked = {"study": study.resolved(), "variant": study.variant_name, "fidelity": self.fidelity}
        plan = {
            "discretisation": asdict(self.discretisation),
            "meshes": [asdict(stage) for stage in self.meshes.stages],
            "milestones": self.milestones,
            "added": added_code((*study.effects, study.contact.friction_law)),
        }
        return identity_of(asked, RUN_CODE, plan)
