"""What one run is to do: resolution, meshes, and the cycles at which its loop is measured."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace

import numpy as np

from solvers import ContactProblem, ContactState
from wirewear.base.identity import RUN_CODE, Identity, added_code, identity_of
from wirewear.simulation.checkpoint import MeshHistory, Report
from wirewear.simulation.cycler import FrettingTest, Motion
from wirewear.simulation.discretisation import Discretisation, discretise
from wirewear.simulation.expected_contact import ExpectedContact
from wirewear.simulation.mesh_stages import MeshStage, mesh_stages, spare_stages
from wirewear.simulation.problem import contact_problem, fresh_state, problem_at, with_nodes_moved, worn_depths
from wirewear.study import Study
from wirewear.study.consistency import default_loop_cycles
from wirewear.study.fidelity import WIRE_LEVELS, level_of


@dataclass(frozen=True)
class PointMeshes:
    """The meshes that a study's run goes through, and when it takes the next.

    stages: planned, taken as the scar grows.  spare: taken one after another where the contact leaves those.
    move_nodes_at_stages: whether the nodes of every stage but the first are moved into the worn surface when it begins.
    """

    study: Study
    expected: ExpectedContact
    stages: tuple[MeshStage, ...]
    spare: tuple[MeshStage, ...] = ()
    move_nodes_at_stages: bool = False

    def first(self) -> MeshHistory:
        """The stage for bodies that have lost no more than what an effect flattens before the first cycle."""
        stage = 0
        while self._outgrown(stage, self.expected.flattened_mm3):
            stage += 1
        return MeshHistory(stage)

    def problem(self, history: MeshHistory, report: Report) -> ContactProblem:
        """The contact problem on a run's meshes."""
        problem = contact_problem(self.study, self._stage(history.stage), report)
        if history.moved is None:
            return problem
        return with_nodes_moved(problem, self.study, self._stage(history.stage), history.moved, report)[0]

    def next_stage(self, history: MeshHistory, cycle: float) -> MeshHistory | None:
        """The history with the meshes for a larger scar begun; None where there are none."""
        stage = history.stage + 1
        if stage == len(self.stages) + len(self.spare):
            return None
        change = {"cycle": cycle, "half_width_um": 1e3 * self._stage(stage).from_half_width_mm}
        return replace(history, stage=stage, moved=None, changes=(*history.changes, change))

    def outgrown(self, history: MeshHistory, state: ContactState, cycle: float) -> MeshHistory | None:
        """The next stage, if there is one and the scar has grown beyond what the meshes of now are for."""
        worn = state.wear.primary_volume_mm3 + state.wear.secondary_volume_mm3
        return self.next_stage(history, cycle) if self._outgrown(history.stage, worn) else None

    def moved_nodes(
        self, history: MeshHistory, problem: ContactProblem, state: ContactState, cycle: float, report: Report
    ) -> tuple[MeshHistory, ContactProblem]:
        """History and problem with the nodes moved into the worn surface where the study asks for it, else as is."""
        if not self._motion_due(history, problem, state):
            return history, problem
        depths = worn_depths(problem, state)
        moved, smallest = with_nodes_moved(problem, self.study, self._stage(history.stage), depths, report)
        change = {
            "cycle": cycle,
            "moved_to_um": 1e3 * float(max(depth.max() for depth in depths)),
            "smallest_scaled_jacobian": smallest,
        }
        return replace(history, moved=depths, changes=(*history.changes, change)), moved

    def _motion_due(self, history: MeshHistory, problem: ContactProblem, state: ContactState) -> bool:
        """Whether the worn surfaces have left their nodes by as much as the study allows."""
        every_um = self.study.mesh.move_nodes_every_um
        if every_um is None:
            return self.move_nodes_at_stages and history.stage > 0 and history.moved is None
        depths = worn_depths(problem, state)
        moved = history.moved or (np.zeros(1), np.zeros(1))
        ahead = max(float(np.abs(depth - before).max()) for depth, before in zip(depths, moved, strict=True))
        return ahead > 0.0 and ahead >= 1e-3 * every_um

    @property
    def all_stages(self) -> tuple[MeshStage, ...]:
        """Planned ones, then spare ones."""
        return (*self.stages, *self.spare)

    def _stage(self, index: int) -> MeshStage:
        return self.all_stages[index]

    def _outgrown(self, stage: int, volume_mm3: float) -> bool:
        if stage + 1 >= len(self.stages):
            return False
        return self.expected.scar_half_width_mm(volume_mm3) >= self.stages[stage].to_half_width_mm


@dataclass(frozen=True)
class RunPlan:
    """A study without variants, or one of its variants, at a fidelity."""

    study: Study
    fidelity: str
    discretisation: Discretisation
    meshes: PointMeshes

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
        meshes = PointMeshes(study, discretisation.expected, stages, spare, moves)
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

        Worn bodies touch in a band across the motion. Elements across the motion come near that diameter, so means over
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
