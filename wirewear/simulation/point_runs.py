"""Planned runs of contacts at a point: what they mesh, measure and record, and the memory and jumps that they need.

Bodies come as (driven, held). A milestone is a cycle whose loop is measured; it is logged if loop and scars are
recorded, too.
"""

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from geometry import BodyGeometry, GeometryError
from solvers import ContactProblem, ContactState, CycleTrace, IncrementReport, PlacedBody
from wirewear.base.cache import Identity
from wirewear.base.errors import StudyError
from wirewear.base.memory import free_memory
from wirewear.base.words import counted
from wirewear.results import PRESSURE_LENGTH, ContactForces, RunResult, Scar
from wirewear.results.export import TIME_SERIES_FILES
from wirewear.results.values import PlasticStrain
from wirewear.simulation.discretisation import Discretisation, discretise, unknowns
from wirewear.simulation.meshes import MeshHistory, PointMeshes
from wirewear.simulation.near_zone import near_zone_of
from wirewear.simulation.plan import FrettingTest, PlannedRun, PointMotion
from wirewear.simulation.problem import Announce, condense_bodies, too_much
from wirewear.simulation.recorded import MEASURED, Recorded, holder_settings
from wirewear.simulation.statistics import bends
from wirewear.simulation.traced_bodies import forces_on, scars_of
from wirewear.test import Study
from wirewear.test.consistency import default_loop_cycles
from wirewear.test.fidelity import WIRE_LEVELS, level_of

#: Files that `wirewear show` and `report` make in a run's folder; here, since importing the drawing takes long.
PICTURES = (
    "report.html",
    *(
        f"pictures/{name}.{ending}"
        for name in ("loops", "evolution", "scars_from_above", "contact*", "scar_series*", "sections", "scars_3d")
        for ending in ("png", "svg", "pdf")
    ),
    "pictures/loop_and_scar*.gif",
)
#: Of the energy so far: what loops around a core may leave out. The few increments of its cycles miss as much.
_AROUND_CORE = 1e-2
MOST_JUMPS = 1_000_000  #: Cycle jumps that a run may take: at some tenths of a second each, days.


@dataclass(frozen=True)
class PointRun(PlannedRun):
    """A study of a contact at a point at a fidelity, with its meshes. derived: files that are made from its result."""

    study: Study
    meshes: PointMeshes

    derived: ClassVar[tuple[str, ...]] = (*TIME_SERIES_FILES, *PICTURES)

    @classmethod
    def of(cls, study: Study, fidelity: str) -> "PointRun":
        """The planned run of a study without variants. Raises StudyError if the study cannot be discretised."""
        return cls(study, fidelity, PointMeshes.planned(study, fidelity))

    @property
    def discretisation(self) -> Discretisation:
        return self.meshes.discretisation

    def recorder(self) -> "PointRunRecord":
        """An empty record for the run."""
        return PointRunRecord(self)

    @property
    def test(self) -> FrettingTest:
        """The test as `cycle_through` simulates it."""
        wear, tolerance = self.study.wear, self.discretisation.jump_tolerance
        jump = wear.explicit_jump_cycles if wear else None
        return self.tested(self.study, self.motion, self.meshes, self.milestones, tolerance, jump)

    def motion(self, block: Study) -> PointMotion:
        """The motion of a block of cycles from the block's own study."""
        sizes = self.discretisation
        increments = sizes.increments_per_cycle, sizes.increments_per_wear_cycle
        return PointMotion.of(block, near_zone_of(self.study), increments, self.fidelity)

    @property
    def logged_cycles(self) -> tuple[int, ...]:
        """Cycles whose loop and scars are recorded, increasing."""
        return self.study.log.loop_cycles or default_loop_cycles(self.study.conditions.cycles)

    @property
    def pressure_length_mm(self) -> float:
        """Diameter of the discs over which mean pressures are taken: as stated, or that of the fresh contact.

        Worn bodies touch in a band across the motion. Elements across the motion are nearly as large as this diameter,
        so means over smaller discs would be those of single elements (docs/accuracy.md).
        """
        stated = self.study.log.pressure_length_um
        return 2.0 * self.discretisation.hertz.contact_radius_mm if stated is None else 1e-3 * stated

    @property
    def milestones(self) -> tuple[float, ...]:
        """Cycles whose loop is measured, increasing: those to be logged, the last, and those of the series 1, 2, 5, 10,
        ... whose ratio to every logged one is at least the fidelity's `loop_spacing`.
        """
        spacing, logged = level_of(WIRE_LEVELS, self.fidelity).loop_spacing, self.logged_cycles
        between = (
            cycle
            for cycle in default_loop_cycles(self.study.conditions.cycles)
            if all(max(cycle / other, other / cycle) >= spacing for other in logged)
        )
        return tuple(float(cycle) for cycle in sorted({*logged, *between, self.study.conditions.cycles}))

    @cached_property
    def identity(self) -> Identity:
        return self.identified(
            {
                "discretisation": asdict(self.discretisation),
                "meshes": [asdict(stage) for stage in self.meshes.stages],
                "milestones": self.milestones,
            }
        )

    @property
    def needed_memory(self) -> float:
        sizes = [(unknowns(stage.moving), unknowns(stage.fixed)) for stage in self.meshes.stages]
        # Of every logged cycle: four fields on both patches.
        logged = len(self.logged_cycles) * max(8.0 * 4 * sum(pair) / 3.0 for pair in sizes)
        return max(_of_pair(*pair) for pair in sizes) + logged

    def require_affordable(self) -> None:
        """Raise StudyError, with what would fit, for more memory than is free or more than MOST_JUMPS cycle jumps."""
        jump = self.study.wear.explicit_jump_cycles if self.study.wear else None
        cycles = self.study.conditions.cycles
        if jump is not None and cycles / jump > MOST_JUMPS:
            raise StudyError(
                f"explicit_jump_cycles = {jump:g} in [wear] asks for {counted(cycles / jump)} cycle jumps, which take "
                f'months: give at least {cycles / MOST_JUMPS:.2g}, or update = "implicit", whose jumps grow with the '
                "cycles."
            )
        needed, free = self.needed_memory, free_memory()
        if needed > free:
            most = max(max(unknowns(stage.moving), unknowns(stage.fixed)) for stage in self.meshes.stages)
            raise too_much(_at(self.study, self.fidelity), most // 3, needed, free, _what_fits(self, free))

    def prepare(self, announce: Announce) -> None:
        """Condense the bodies of all planned stages and cache them. announce: called with the name of each part."""
        for meshes in self.meshes.stages:
            condense_bodies(self.study, meshes, announce)


class PointRunRecord(Recorded):
    """The record of one run of a contact at a point; `Recorded` says what its methods do."""

    length_mm = None

    def __init__(self, plan: PointRun) -> None:
        super().__init__(plan.study, plan.fidelity, plan.pressure_length_mm)
        self.plan = plan
        self.contact_kind, self.bodies = plan.study.contact_kind, plan.discretisation.bodies
        self._plastic_strain: tuple[PlasticStrain, ...] = ()

    def restore(self, before: RunResult, done: float) -> None:
        super().restore(before, done)
        self._plastic_strain = before.plastic_strain
        # A run that had done its last cycle measures its holder no more.
        self._holder = {name: value for name, value in before.settings.items() if name.startswith(MEASURED)}

    def record_pressed(self, problem: ContactProblem, state: ContactState, report: IncrementReport) -> None:
        super().record_pressed(problem, state, report)
        self.tally.fresh |= {
            "fresh_approach_um": -1e3 * state.holder_z,
            "fresh_contact_radius_um": 1e3 * (report.contact_area / np.pi) ** 0.5,
        }
        if (near := near_zone_of(self.plan.study)) is not None:
            self.tally.fresh |= near.settings
            self._plastic_strain = near.strains(*self.bodies)

    def result(self, status: str, message: str, history: MeshHistory) -> RunResult:
        return replace(super().result(status, message, history), plastic_strain=self._plastic_strain)

    def holder_of(self, problem: ContactProblem, trace: CycleTrace) -> dict[str, float | str]:
        return holder_settings(problem, trace)

    def follows(self, problem: ContactProblem, state: ContactState, done: float, work_mJ: float) -> bool:
        last = self._rows[-1]
        if not super().follows(problem, state, done, work_mJ):
            return False
        if self.schedule.at(last["cycle"]) is not self.schedule.at(done):
            return True  # a loop of another block says nothing of this one's
        if any(layer.friction is not None for layers in self.plan.study.layers.values() for layer in layers):
            # Where friction changes from node to node, cycles differ from their neighbours: loops chosen where they do
            # would be chosen for being high.
            return True
        since = (last["cycle"], last["dissipated_energy_mJ"], 1e3 * last["accumulated_energy_J"])
        now = (done, work_mJ, state.wear.energy_mJ)
        return not (bends(since, now, _AROUND_CORE) if state.core.any() else bends(since, now))

    def logs(self, cycle: int, done: float) -> bool:
        return self.ends or cycle in self.plan.logged_cycles or done >= self.plan.study.conditions.cycles

    def scars(self, problem: ContactProblem, trace: CycleTrace, cycle: int) -> tuple[Scar, Scar]:
        return scars_of(problem, trace, cycle, self.plan.study)

    def forces(self, problem: ContactProblem, trace: CycleTrace, cycle: int) -> tuple[ContactForces, ...]:
        return forces_of(problem, trace, cycle, self.plan)

    def tables(self) -> dict[str, object]:
        return self.plan.study.resolved()

    def settings(self, history: MeshHistory) -> dict[str, object]:
        plan, counters = self.plan, self.tally.counters
        return {
            **plan.discretisation.settings(),
            PRESSURE_LENGTH: 1e3 * plan.pressure_length_mm,
            **self.tally.fresh,
            **self._holder,
            "mesh_changes": list(history.changes),
            "mesh_stages": [1e3 * stage.to_half_width_mm for stage in plan.meshes.stages],
            "increments": counters.increments,
            "simulated_cycles": counters.simulated_cycles,
            "mean_iterations_per_increment": counters.iterations / max(counters.increments, 1.0),
            "identity": str(plan.identity),
        }


def forces_of(problem: ContactProblem, trace: CycleTrace, cycle: int, plan: PointRun) -> tuple[ContactForces, ...]:
    """(driven, held): contact forces in a traced cycle, with geometry and material of the meshes of `problem`; empty if
    the study asks for none.
    """
    study = plan.study
    stage = next(
        stage
        for stage in (*plan.meshes.every, *plan.meshes.fits.values())
        if _is_of(stage.moving, problem.lower) and _is_of(stage.fixed, problem.upper)
    )
    made_of = (stage.moving, study.bodies[0].material), (stage.fixed, study.bodies[1].material)
    return forces_on(problem, trace, cycle, study.log.contact_states, plan.discretisation.bodies, made_of)


def _is_of(geometry: BodyGeometry, body: PlacedBody) -> bool:
    patch = body.patch
    return np.array_equal(geometry.axial.lines(), patch.axial_mm) and np.array_equal(
        geometry.transverse.lines(), patch.transverse_mm
    )


def require_affordable_wires(study: Study, fidelity: str, meshes: Discretisation) -> None:
    """Raise StudyError, with what would fit, if both bodies' compliances take more memory than is free."""
    sizes = (unknowns(meshes.moving), unknowns(meshes.fixed))
    needed, free = _of_pair(*sizes), free_memory()
    if needed > free:
        asked_um = 1e3 * meshes.fixed.transverse.fine_mm
        remedy = _size_that_fits(study, fidelity, asked_um, free)
        raise too_much(_at(study, fidelity), max(sizes) // 3, needed, free, remedy)


def _at(study: Study, fidelity: str) -> str:
    return f"{study.name!r} at {fidelity} fidelity"


def _of_pair(moving: int, fixed: int) -> float:
    """Bytes for bodies with these numbers of unknowns: for compliances stored by quarters and one being computed, or
    for a mesh being made.
    """
    largest = max(moving, fixed)
    compliances = 8.0 / 4.0 * (moving**2 + fixed**2 + largest**2)
    # That gmsh takes for every node of a patch, with all that lies beneath it; measured.
    return max(compliances, 230e3 * largest / 3.0)


def _what_fits(plan: PointRun, free: float) -> str:
    if len(plan.logged_cycles) > 100:
        return "log fewer cycles, or mesh coarser"
    return _size_that_fits(plan.study, plan.fidelity, 1e3 * plan.discretisation.fixed.transverse.fine_mm, free)


def _size_that_fits(study: Study, fidelity: str, asked_um: float, free: float) -> str:
    try:
        element_um = _fitting(lambda size: _memory_of(study, fidelity, size), asked_um, free)
    except (GeometryError, StudyError):  # larger elements do not make a mesh
        return "this needs a machine with more memory"
    return f"give contact_mesh_um = {element_um:.2g} or more in [fidelity.{fidelity}]"


def _memory_of(study: Study, fidelity: str, element_um: float) -> float:
    sizes = discretise(study.changed({"fidelity": {fidelity: {"contact_mesh_um": element_um}}}), fidelity)
    return _of_pair(unknowns(sizes.moving), unknowns(sizes.fixed))


def _fitting(memory_of: Callable[[float], float], element_um: float, free: float) -> float:
    """The first of growing element sizes in µm whose meshes take no more than `free` bytes."""
    while memory_of(element_um) > free:
        element_um *= 1.1
    return element_um
