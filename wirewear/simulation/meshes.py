"""The meshes of a run: new ones as the scar grows, and nodes moved into the worn surface when the study asks for it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from solvers import ContactProblem, ContactState
from wirewear.simulation.expected_contact import ExpectedContact
from wirewear.simulation.mesh_history import MeshHistory, Report
from wirewear.simulation.mesh_stages import MeshStage
from wirewear.simulation.problem import contact_problem, with_nodes_moved, worn_depths
from wirewear.study import Study


@dataclass(frozen=True)
class WireMeshes:
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
        """The stage for wires that have lost no more than what an effect flattens before the first cycle."""
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
