"""The meshes of a run: new ones as the scar grows, and nodes moved into the worn surface when the study asks for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from solvers import ContactProblem, ContactState
from wirewear.simulation.mesh_stages import MeshStage, scar_half_width_mm
from wirewear.simulation.problem import contact_problem, with_nodes_moved, worn_depths
from wirewear.study import Study

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MeshHistory:
    """Which meshes a run has.

    stage: index of the stage of the scar's growth.  moved: depth in mm by which the surface nodes of the moving and the
    fixed wire have been moved, None while they are where they were when fresh.  changes: what was changed when.
    """

    stage: int = 0
    moved: tuple[Array, Array] | None = None
    changes: tuple[dict[str, float], ...] = ()

    @property
    def smallest_scaled_jacobian(self) -> float | None:
        """Of all meshes with moved nodes so far."""
        name = "smallest_scaled_jacobian"
        return min((change[name] for change in self.changes if name in change), default=None)


@dataclass(frozen=True)
class RunMeshes:
    """The meshes that a study's run goes through, and when it takes the next."""

    study: Study
    stages: tuple[MeshStage, ...]

    def first(self, volume_mm3: float) -> MeshHistory:
        """The stage for wires that have lost a volume before the first cycle."""
        stage = 0
        while self._outgrown(stage, volume_mm3):
            stage += 1
        return MeshHistory(stage)

    def problem(self, history: MeshHistory, report: Callable[[str], None]) -> ContactProblem:
        """The contact problem on a run's meshes."""
        problem = contact_problem(self.study, self.stages[history.stage], report)
        if history.moved is None:
            return problem
        return with_nodes_moved(problem, self.study, self.stages[history.stage], history.moved, report)[0]

    def due_stage(self, history: MeshHistory, state: ContactState) -> bool:
        """Whether the scar has grown beyond what the meshes are for."""
        return self._outgrown(history.stage, state.wear.primary_volume_mm3 + state.wear.secondary_volume_mm3)

    def more_stages(self, history: MeshHistory) -> bool:
        """Whether there are meshes for a larger scar."""
        return history.stage + 1 < len(self.stages)

    def next_stage(self, history: MeshHistory, cycle: float) -> MeshHistory:
        """The history with the next stage begun."""
        change = {"cycle": cycle, "half_width_um": 1e3 * self.stages[history.stage + 1].from_half_width_mm}
        return replace(history, stage=history.stage + 1, moved=None, changes=(*history.changes, change))

    def due_motion(self, history: MeshHistory, problem: ContactProblem, state: ContactState) -> bool:
        """Whether the worn surfaces have left their nodes by as much as the study allows."""
        every_um = self.study.mesh.move_nodes_every_um
        if every_um is None:
            return False
        depths = worn_depths(problem, state)
        moved = history.moved or (np.zeros(1), np.zeros(1))
        ahead = max(float(np.abs(depth - before).max()) for depth, before in zip(depths, moved, strict=True))
        return ahead > 0.0 and ahead >= 1e-3 * every_um

    def with_nodes_moved(
        self,
        history: MeshHistory,
        problem: ContactProblem,
        state: ContactState,
        cycle: float,
        report: Callable[[str], None],
    ) -> tuple[MeshHistory, ContactProblem]:
        """The problem with both wires' nodes moved into the worn surface."""
        depths = worn_depths(problem, state)
        moved, smallest = with_nodes_moved(problem, self.study, self.stages[history.stage], depths, report)
        change = {
            "cycle": cycle,
            "moved_to_um": 1e3 * float(max(depth.max() for depth in depths)),
            "smallest_scaled_jacobian": smallest,
        }
        return replace(history, moved=depths, changes=(*history.changes, change)), moved

    def _outgrown(self, stage: int, volume_mm3: float) -> bool:
        if stage + 1 >= len(self.stages):
            return False
        return scar_half_width_mm(self.study, volume_mm3) >= self.stages[stage].to_half_width_mm
