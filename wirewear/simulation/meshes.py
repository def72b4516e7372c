"""The meshes that a run goes through: which there are, when the next ones are taken, and which it is on.

A stage is a pair of meshes that serves while the scar grows from one half-width to another; stage -1 serves while a
fresh contact sticks in its middle. The core is the part that sticks; its nodes carry all once the annulus around it has
worn.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from math import ceil, log

import numpy as np

from geometry import BodyGeometry
from geometry.arrays import Array
from solvers import ContactProblem, ContactState, recoated, stuck_share, transferred_wear
from solvers.contact_state import WearState
from solvers.transfer import lies_within
from wirewear.base.errors import StudyError
from wirewear.simulation.control import core_of_held_force, core_once_worn, point_sticks
from wirewear.simulation.discretisation import Discretisation, ElementSizes, affordable_meshes, discretise, follows
from wirewear.simulation.expected_contact import ExpectedContact, stands_out
from wirewear.simulation.line_model import LinePlan, bodies, limit_of_lines, line_problem
from wirewear.simulation.problem import Announce, contact_problem, held_is_primary, with_nodes_moved, worn_depths
from wirewear.test import LineStudy, Study
from wirewear.test.fidelity import WIRE_LEVELS, level_of

_GROWTH_PER_STAGE = 1.8  #: Growth of the scar's half-width that one mesh is to serve.
_LEAST_GROWTH = 1.1
_STICKING = -1  # The stage for a fresh contact that sticks in its middle.


@dataclass(frozen=True)
class MeshHistory:
    """Which meshes a run is on, and how they have changed. stage: index of the pair of meshes, -1 for those of a fresh
    contact that sticks in its middle. moved: depths in mm by which surface nodes of the lower and the upper body were
    moved, None if they were not. changes: each with its cycle. core: share (0 to 1) of the fresh contact's axes that
    sticks and that mesh lines follow, None if they need not.
    """

    stage: int = 0
    moved: tuple[Array, Array] | None = None
    changes: tuple[dict[str, float], ...] = ()
    core: float | None = None


class Meshes(ABC):
    """The meshes that a run goes through, and when it takes the next; by default the same ones to its end.

    Histories are not changed: methods return the one that follows, or None if meshes stay as they are. announce:
    called with the name of each part of the work.
    """

    def first(self) -> MeshHistory:
        """The history with the meshes for the fresh contact."""
        return MeshHistory()

    @abstractmethod
    def problem(self, history: MeshHistory, announce: Announce, /) -> ContactProblem:
        """The contact problem on the meshes of a history, without effects of the test's age."""

    def next_stage(self, _history: MeshHistory, _cycle: float, /) -> MeshHistory | None:
        """The history with the next, larger meshes in use from `_cycle` on; None if there are none."""
        return None

    def outgrown(self, _history: MeshHistory, _state: ContactState, _cycle: float, /) -> MeshHistory | None:
        """The history with the next meshes in use from `_cycle` on, if the scar has outgrown these; else None."""
        return None

    def fitting(
        self, _history: MeshHistory, _state: ContactState, _cycles: tuple[float, float], _sticks: bool, /
    ) -> MeshHistory | None:
        """The history with the meshes for a contact that sticks in its middle or that slides, if those in use are not;
        else None.
        _cycles: at which the current motion began, and now. _sticks: True if the middle stuck throughout the latest
        cycle. Such meshes are left and taken again at most once during a motion.
        """
        return None

    def fitted(self, _history: MeshHistory, _problem: ContactProblem, _state: ContactState, /) -> MeshHistory | None:
        """The history with mesh lines that follow the core at the end of the first loading; None if they need not."""
        return None

    def moved_nodes(
        self, history: MeshHistory, problem: ContactProblem, _state: ContactState, _cycle: float, _announce: Announce, /
    ) -> tuple[MeshHistory, ContactProblem]:
        """(history, problem) with nodes moved into the worn surface, if due after `_cycle` cycles; else as given."""
        return history, problem

    def coats_worn(
        self, problem: ContactProblem, _state: ContactState, _of: ContactProblem | None = None, /
    ) -> ContactProblem:
        """The problem with what is left of layers of other materials in a state on its meshes, or on those of `_of`."""
        return problem


class _CoatedMeshes(Meshes):
    """Meshes of bodies that may have layers of other materials."""

    def coats_worn(
        self, problem: ContactProblem, state: ContactState, of: ContactProblem | None = None, /
    ) -> ContactProblem:
        if problem.primary.coats is None:
            return problem
        patches = [(each.primary.patch, each.secondary.patch) for each in (of or problem, problem)]
        return recoated(problem, state.wear if of is None else transferred_wear(state.wear, *patches))


@dataclass(frozen=True)
class LineMeshes(_CoatedMeshes):
    """The one pair of meshes on which a line contact runs to its end; a contact that leaves them has failed.
    study: of 1 mm of length, with the driven body's stroke.
    """

    study: LineStudy
    planned: LinePlan

    def problem(self, _history: MeshHistory, announce: Announce, /) -> ContactProblem:
        announce("meshing and condensing")
        limit = limit_of_lines(self.study, self.planned.hertz)
        return replace(line_problem(self.study, *bodies(self.study, self.planned)), limit=limit)


@dataclass(frozen=True)
class MeshStage:
    """Meshes of the driven (moving) and the held body while the scar's half-width grows between two values."""

    from_half_width_mm: float
    to_half_width_mm: float
    moving: BodyGeometry
    fixed: BodyGeometry


def mesh_stages(study: Study, fidelity: str, sizes: Discretisation) -> tuple[MeshStage, ...]:
    """Stages from the fresh contact to the predicted scar, with equal growth in each.

    A single one, on the meshes of `sizes`, if nothing wears, if the scar stays below 1.8 times the fresh contact,
    or if the study states sizes of its own or asks for one mesh. Raises StudyError if a patch would not fit on its
    body.
    """
    fresh, scar = sizes.expected.fresh, sizes.expected.scar
    growth = 1.0 if scar is None else scar.major_mm / fresh.major_mm
    if growth <= _GROWTH_PER_STAGE or not follows(study, fidelity):
        return (MeshStage(fresh.major_mm, growth * fresh.major_mm, sizes.moving, sizes.fixed),)
    count = ceil(log(growth) / log(_GROWTH_PER_STAGE))
    widths = [fresh.major_mm * growth ** (k / count) for k in range(count + 1)]
    return tuple(_stage(study, sizes, low, high, fresh=k == 0) for k, (low, high) in enumerate(pairwise(widths)))


def spare_stages(study: Study, fidelity: str, sizes: Discretisation, last: MeshStage) -> tuple[MeshStage, ...]:
    """At most three stages beyond `last`, for contacts that leave it, as over soft layers or under changing loads.
    Fewer where larger patches do not fit on the bodies; none if the study states sizes of its own or asks for one mesh.
    """
    stages: list[MeshStage] = []
    width, growth = last.to_half_width_mm, _GROWTH_PER_STAGE
    while follows(study, fidelity) and len(stages) < 3 and growth > _LEAST_GROWTH:
        try:
            stages.append(_stage(study, sizes, width, growth * width, fresh=False))
            width *= growth
        except StudyError:
            growth = growth**0.5
    return tuple(stages)


def _stage(study: Study, sizes: Discretisation, now_mm: float, then_mm: float, *, fresh: bool) -> MeshStage:
    """Meshes for a scar whose largest half-width is `now_mm` and is to grow to `then_mm`.

    The patch holds the grown scar with the same margin as in a run on one mesh. The first stage resolves the fresh
    contact along its whole path, the others the grown scar up to its edges.
    """
    contact = sizes.expected.fresh
    shape = sizes.expected.scar or contact
    elements = ElementSizes(contact, shape.enlarged(then_mm / shape.major_mm), fresh=fresh)
    moving, fixed, _ = affordable_meshes(study, elements, sizes.level)
    return MeshStage(now_mm, then_mm, moving, fixed)


def sticking_stage(study: Study, fidelity: str, sizes: Discretisation) -> MeshStage | None:
    """Meshes for a fresh contact that sticks in its middle; None if those of `sizes` serve it, if none fit, or if the
    study states sizes of its own or asks for one mesh.
    """
    if sizes.expected.sticks or not follows(study, fidelity):
        return None
    sticking = discretise(study, fidelity, sticks=True)
    fresh_mm = sizes.expected.fresh.major_mm
    fits = sticking.expected.sticks and sticking.expected.face is None
    # A scar is no larger than the fresh contact by this factor.
    return MeshStage(fresh_mm, 1.05 * fresh_mm, sticking.moving, sticking.fixed) if fits else None


def core_stages(study: Study, fidelity: str, sizes: Discretisation) -> Callable[[float], MeshStage] | None:
    """A function that makes meshes for a core, by its share (0 to 1) of the fresh contact's axes; None without wear, on
    a pad, or if the study states sizes of its own or asks for one mesh.
    """
    if study.wear is None or sizes.expected.face is not None or not follows(study, fidelity):
        return None
    # Runs in other processes take their plan along, so this is no function within a function.
    return partial(_core_stage, study, fidelity, sizes.expected.fresh.major_mm)


def _core_stage(study: Study, fidelity: str, fresh_mm: float, core: float) -> MeshStage:
    sticking = discretise(study, fidelity, sticks=True, core=core)
    return MeshStage(fresh_mm, fresh_mm, sticking.moving, sticking.fixed)


@dataclass(frozen=True)
class PointMeshes(_CoatedMeshes):
    """The meshes that a run of a contact at a point goes through, and when it takes the next ones; see `Meshes`.

    stages: taken as the scar grows; spare: where the contact leaves these. sticking: stage -1, None for none;
    begins_sticking: True if it is expected to be needed first. for_core: meshes for a core by its share of the fresh
    contact's axes, None for none, fits: those made so far. move_nodes_at_stages: True if the nodes of later stages are
    moved into the worn surface.
    """

    study: Study
    discretisation: Discretisation
    stages: tuple[MeshStage, ...]
    spare: tuple[MeshStage, ...] = ()
    sticking: MeshStage | None = None
    begins_sticking: bool = False
    for_core: Callable[[float], MeshStage] | None = None
    move_nodes_at_stages: bool = False
    fits: dict[float, MeshStage] = field(default_factory=dict, compare=False)

    @classmethod
    def planned(cls, study: Study, fidelity: str) -> PointMeshes:
        """The meshes for a study without variants. Raises StudyError if the study cannot be discretised."""
        driven = study.driven
        largest, regimes = driven.envelope, [point_sticks(own) for own in driven.schedule.studies]
        sizes = discretise(largest, fidelity, sticks=all(regimes))
        stages = mesh_stages(largest, fidelity, sizes)
        spare = spare_stages(largest, fidelity, sizes, stages[-1])
        if said := stands_out(study, [*stages, *spare][-1].to_half_width_mm):
            raise StudyError(f"{said}.")
        moves = level_of(WIRE_LEVELS, fidelity).move_nodes_at_stages or study.mesh.move_nodes_at_stages
        sticking, cores = sticking_stage(largest, fidelity, sizes), core_stages(largest, fidelity, sizes)
        return cls(driven, sizes, stages, spare, sticking, regimes[0], cores, moves)

    @property
    def expected(self) -> ExpectedContact:
        return self.discretisation.expected

    @property
    def every(self) -> tuple[MeshStage, ...]:
        """All stages in order; the stage for a sticking contact is last, and so has the index -1."""
        return (*self.stages, *self.spare, *(() if self.sticking is None else (self.sticking,)))

    def first(self) -> MeshHistory:
        if self.begins_sticking and self.sticking is not None:
            return MeshHistory(_STICKING, core=self._stated_core)
        stage = 0
        while self._outgrown(stage, self.expected.flattened_mm3):
            stage += 1
        return MeshHistory(stage, core=self._stated_core if self.expected.sticks and stage == 0 else None)

    @property
    def _stated_core(self) -> float | None:
        """The core under the tangential force that a study holds; None where that is to be seen."""
        one_block = len(self.study.schedule.stretches) == 1
        return core_of_held_force(self.study) if one_block and self.for_core is not None else None

    def problem(self, history: MeshHistory, announce: Announce) -> ContactProblem:
        meshes = self.every[history.stage]
        if history.core is not None and self.for_core is not None:
            meshes = self.fits[history.core] = self.fits.get(history.core) or self.for_core(history.core)
        problem = contact_problem(self.study, meshes, announce)
        if history.moved is None:
            return problem
        return with_nodes_moved(problem, self.study, self.every[history.stage], history.moved, announce)[0]

    def next_stage(self, history: MeshHistory, cycle: float) -> MeshHistory | None:
        stage = history.stage + 1
        if stage == len(self.stages) + len(self.spare):
            return None
        change = {"cycle": cycle, "half_width_um": 1e3 * self.every[stage].from_half_width_mm}
        return replace(history, stage=stage, moved=None, core=None, changes=(*history.changes, change))

    def outgrown(self, history: MeshHistory, state: ContactState, cycle: float) -> MeshHistory | None:
        worn = state.wear.primary_volume_mm3 + state.wear.secondary_volume_mm3
        return self.next_stage(history, cycle) if self._outgrown(history.stage, worn) else None

    def fitting(
        self, history: MeshHistory, state: ContactState, cycles: tuple[float, float], sticks: bool, /
    ) -> MeshHistory | None:
        worn = state.wear.primary_volume_mm3 + state.wear.secondary_volume_mm3
        if self.sticking is None or history.stage != (0 if sticks else _STICKING):
            return None
        since, now = cycles
        back = any(change["cycle"] > since for change in history.changes)
        if sticks and (
            back
            or self.expected.scar_half_width_mm(worn) > self.sticking.to_half_width_mm
            or not self._holds(self.sticking, self.every[history.stage], state.wear)
        ):
            return None
        return self.next_stage(replace(history, stage=_STICKING - 1 if sticks else _STICKING), now)

    def _holds(self, meshes: MeshStage, now: MeshStage, wear: WearState) -> bool:
        """True if the patches of other meshes hold what has slid, or a print, on those in use, `now`."""
        bodies = [(now.fixed, meshes.fixed), (now.moving, meshes.moving)]
        pairs = bodies if held_is_primary(self.study) else bodies[::-1]
        slid = wear.primary_energy, wear.secondary_energy
        return all(
            lies_within(
                energy + (0.0 if moved is None else np.abs(moved)) > 0.0,
                *((body.axial.lines(), body.transverse.lines()) for body in pair),
            )
            for pair, energy, moved in zip(pairs, slid, wear.prints, strict=True)
        )

    def fitted(self, history: MeshHistory, problem: ContactProblem, state: ContactState, /) -> MeshHistory | None:
        sticking = history.stage == (0 if self.expected.sticks else _STICKING)
        if self.for_core is None or not sticking or history.core is not None:
            return None
        core = stuck_share(problem, state)
        if not 0.0 < core < 1.0:
            return None
        force_N = abs(float(state.primary_force[:, 0].sum()))
        return replace(history, core=core_once_worn(self.study, core, abs(float(state.drive)) / force_N))

    def moved_nodes(
        self, history: MeshHistory, problem: ContactProblem, state: ContactState, cycle: float, announce: Announce
    ) -> tuple[MeshHistory, ContactProblem]:
        if not self._motion_due(history, problem, state):
            return history, problem
        depths = worn_depths(problem, state)
        moved, smallest = with_nodes_moved(problem, self.study, self.every[history.stage], depths, announce)
        change = {
            "cycle": cycle,
            "moved_to_um": 1e3 * float(max(depth.max() for depth in depths)),
            "smallest_scaled_jacobian": smallest,
        }
        return replace(history, moved=depths, changes=(*history.changes, change)), moved

    def _motion_due(self, history: MeshHistory, problem: ContactProblem, state: ContactState) -> bool:
        """True if the worn surfaces are deeper than their nodes by as much as the study allows."""
        every_um = self.study.mesh.move_nodes_every_um
        if every_um is None:
            return self.move_nodes_at_stages and history.stage > 0 and history.moved is None
        depths = worn_depths(problem, state)
        moved = history.moved or (np.zeros(1), np.zeros(1))
        ahead = max(float(np.abs(depth - before).max()) for depth, before in zip(depths, moved, strict=True))
        return ahead > 0.0 and ahead >= 1e-3 * every_um

    def _outgrown(self, stage: int, volume_mm3: float) -> bool:
        if stage == _STICKING or stage + 1 >= len(self.stages):
            return False
        return self.expected.scar_half_width_mm(volume_mm3) >= self.stages[stage].to_half_width_mm
