"""Runs of line contacts: planned and recorded for one millimetre, in plane strain. Cycles and solvers are those of any
run.

Bodies come as (specimen, pad): driven and below, held and above.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from geometry import EdgeGradedAxis, PlanarGeometry, RingGeometry
from solvers import ContactProblem, CycleTrace, press, unloaded_state
from wirewear.base import kinds
from wirewear.base.cache import Identity
from wirewear.base.memory import free_memory
from wirewear.results import ContactForces, Loop, RunResult, Scar
from wirewear.simulation.line_model import LinePlan, bodies, line_plan, line_problem
from wirewear.simulation.meshes import LineMeshes, MeshHistory
from wirewear.simulation.plan import FrettingTest, LineMotion, PlannedRun
from wirewear.simulation.problem import Announce, too_much
from wirewear.simulation.recorded import Recorded
from wirewear.simulation.traced_bodies import forces_on, worn_bodies
from wirewear.test import LineStudy


class LineRunRecord(Recorded):
    """The record of one run of a line contact, of 1 mm length; `Recorded` says what its methods do."""

    contact_kind, bodies, length_mm = kinds.LINE_CONTACT, ("specimen", "pad"), 1.0

    def __init__(self, plan: "LineRun") -> None:
        super().__init__(plan.study, plan.fidelity, plan.planned.pressure_length_mm)
        self.study, self._asked = plan.study, plan.planned.settings() | {"identity": str(plan.identity)}

    def restore(self, before: RunResult, done: float) -> None:
        super().restore(before.of_length(self.length_mm), done)

    def result(self, status: str, message: str, history: MeshHistory) -> RunResult:
        """The result so far, converted to the study's length of contact."""
        return super().result(status, message, history).of_length(self.study.contact.length_mm)

    def further_columns(self, loop: Loop, scars: tuple[Scar, Scar]) -> dict[str, float]:
        """Columns of the evolution's row that only line contacts have: the pad's largest tilt in degrees, and x in µm
        of both ends of each scar.
        """
        ends = {
            f"{side}_edge_{scar.body}_um": edge
            for scar in scars
            for side, edge in zip(("left", "right"), scar.edges_um(), strict=True)
        }
        return {"largest_tilt_deg": float(np.abs(loop.tilt_deg).max()), **ends}

    def scars(self, problem: ContactProblem, trace: CycleTrace, cycle: int) -> tuple[Scar, Scar]:
        worn = worn_bodies(problem, trace)
        specimen, pad = (
            Scar(
                cycle=cycle,
                body=body_name,
                diameter_mm=np.inf,
                axis_angle_deg=0.0,
                axial_um=1e3 * body.node_positions[:, 0],
                transverse_um=np.zeros(1),
                depth_um=1e3 * depth,
                energy_density_mJ_per_mm2=energy,
                pressure_MPa=(force[:, 2] / body.patch.node_areas())[:, None],
                slip_distance_um=1e3 * np.reshape(slid, depth.shape),
                length_mm=self.length_mm,
                **{name: 1e3 * field for name, field in further.items()},
            )
            for body_name, (body, depth, energy, force, slid, further) in zip(self.bodies, worn, strict=True)
        )
        return specimen, pad

    def forces(self, problem: ContactProblem, trace: CycleTrace, cycle: int) -> tuple[ContactForces, ...]:
        return forces_on(problem, trace, cycle, self.study.log.contact_states, self.bodies)

    def tables(self) -> dict[str, object]:
        return self.study.resolved()

    def settings(self, _history: MeshHistory) -> dict[str, object]:
        return self._asked | self.tally.fresh | {"simulated_cycles": self.tally.counters.simulated_cycles}


def _assembled(study: LineStudy, fidelity: str) -> LineStudy:
    """The study of a shaft, pushed into its hub by a stated force, with the overlap that this leaves; others unchanged.

    The force Q of a shaft that slides inwards along the taper t all over and the sum P of the pressure are as Q/P =
    (µ + t)/(1 − µt).
    """
    force_N = study.specimen.assembly_force_N
    if force_N is None:
        return study
    friction, taper = study.contact.friction, abs(study.specimen.taper)
    load_N = force_N * (1.0 - friction * taper) / (friction + taper)
    loaded = study.with_values({"conditions.normal_load_N": load_N})
    driven = loaded.of_length(1.0).driven
    problem = line_problem(driven, *bodies(driven, line_plan(loaded, fidelity)))
    state, _ = press(problem, unloaded_state(problem))
    return loaded.with_values({"specimen.assembly_force_N": None, "specimen.interference_um": -1e3 * state.holder_z})


@dataclass(frozen=True)
class LineRun(PlannedRun):
    """A line contact's study at a fidelity, with meshes and steps. derived: files that are made from its result."""

    study: LineStudy
    planned: LinePlan

    derived: ClassVar[tuple[str, ...]] = (
        "report.html", "profiles.png", "loops.png", "variants.png", "profiles.csv", "loops.csv", "evolution.csv",
    )  # fmt: skip

    @classmethod
    def of(cls, study: LineStudy, fidelity: str) -> "LineRun":
        """The planned run of a study without variants; StudyError if it cannot be meshed."""
        study = _assembled(study, fidelity)
        return cls(study, fidelity, line_plan(study, fidelity))

    def recorder(self) -> LineRunRecord:
        """An empty record for the run."""
        return LineRunRecord(self)

    @property
    def computed(self) -> LineStudy:
        return self.study.of_length(1.0)

    @property
    def identity(self) -> Identity:
        return self.identified(self.planned.settings())

    @property
    def test(self) -> FrettingTest:
        """The test as `cycle_through` simulates it, for 1 mm of length."""
        study = self.study
        milestones = tuple(float(cycle) for cycle in sorted({1, *study.log.loop_cycles, study.conditions.cycles}))
        meshes = LineMeshes(self.computed.driven, self.planned)
        return self.tested(self.computed, self.motion, meshes, milestones, self.planned.jump_tolerance)

    def motion(self, block: LineStudy) -> LineMotion:
        """The motion of a block of cycles from the block's own study, of 1 mm."""
        return LineMotion.of(block, self.planned.increments_per_cycle)

    def require_affordable(self) -> None:
        """Raise StudyError if the compliances of both bodies take more memory than is free."""
        require_affordable_lines(self.study.name, self.planned)

    @property
    def needed_memory(self) -> float:
        return _needed_memory(self.planned)

    def prepare(self, _announce: Announce) -> None:
        """Does nothing: there is nothing that runs of line contacts share and that could be made before them."""


def _needed_memory(meshes: LinePlan) -> float:
    """Bytes that the compliances of both bodies take at a time."""
    # Dense matrices of a contact's unknowns that are there at a time: those of both bodies, and one in the making.
    return 3 * 8.0 * (2.0 * _nodes(meshes)) ** 2


def require_affordable_lines(name: str, meshes: LinePlan) -> None:
    """Raise StudyError if the compliances of both bodies take more memory than is free. name: the study's."""
    needed, free = _needed_memory(meshes), free_memory()
    if needed > free:
        fits_um = 1e3 * meshes.pad.along.fine_mm * (needed / free) ** 0.5
        raise too_much(f"{name!r}", _nodes(meshes), needed, free, f"give contact_mesh_um = {fits_um:.2g} or more")


def _nodes(meshes: LinePlan) -> int:
    return max(_fine_nodes(meshes.pad), _fine_nodes(meshes.specimen))


def _fine_nodes(body: PlanarGeometry | RingGeometry) -> int:
    """Number of nodes in the fine zone of a body's contact; those outside are fewer."""
    along = body.along
    if isinstance(along, EdgeGradedAxis):
        fine_mm = along.half_extent_mm - along.fine_from_mm
    else:
        fine_mm = along.fine_half_extent_mm
    return int(2.0 * fine_mm / along.fine_mm) + 1
