"""Which meshes a run has, and what a run asks of those who make them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from solvers import ContactProblem, ContactState

Array = NDArray[np.float64]

#: Told what is being prepared.
Report = Callable[[str], None]


@dataclass(frozen=True)
class MeshHistory:
    """Which meshes a run has.

    stage: index of the stage of the scar's growth.  moved: depth in mm by which the surface nodes of the lower and the
    upper body have been moved, None while they are where they were when fresh.  changes: what was changed when.
    """

    stage: int = 0
    moved: tuple[Array, Array] | None = None
    changes: tuple[dict[str, float], ...] = ()


class Meshes(Protocol):
    """The meshes that a run goes through, and when it takes the next."""

    def first(self) -> MeshHistory:
        """The meshes of the fresh contact."""

    def problem(self, history: MeshHistory, report: Report, /) -> ContactProblem:
        """The contact problem on a run's meshes."""

    def next_stage(self, history: MeshHistory, cycle: float, /) -> MeshHistory | None:
        """The history with the meshes for a larger scar begun; None where there are none."""

    def outgrown(self, history: MeshHistory, state: ContactState, cycle: float, /) -> MeshHistory | None:
        """The next stage, if there is one and the scar has grown beyond what the meshes of now are for."""

    def moved_nodes(
        self, history: MeshHistory, problem: ContactProblem, state: ContactState, cycle: float, report: Report, /
    ) -> tuple[MeshHistory, ContactProblem]:
        """History and problem with the nodes moved into the worn surface where that is due, else as they are."""


@dataclass(frozen=True)
class OneMesh:
    """Meshes that serve a whole run; `build` makes the problem on them."""

    build: Callable[[], ContactProblem]

    def first(self) -> MeshHistory:
        """The only one."""
        return MeshHistory()

    def problem(self, _history: MeshHistory, report: Report) -> ContactProblem:
        """The contact problem."""
        report("meshing and condensing")
        return self.build()

    def next_stage(self, _history: MeshHistory, _cycle: float) -> MeshHistory | None:
        """There is none."""
        return None

    def outgrown(self, _history: MeshHistory, _state: ContactState, _cycle: float) -> MeshHistory | None:
        """The scar never outgrows them; where the contact leaves them, the run has failed."""
        return None

    def moved_nodes(
        self, history: MeshHistory, problem: ContactProblem, _state: ContactState, _cycle: float, _report: Report
    ) -> tuple[MeshHistory, ContactProblem]:
        """Nodes stay."""
        return history, problem
