"""Runs of line contacts: the cycles and solvers are those of the wires, in plane strain."""

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from solvers import ContactProblem, CycleTrace, unloaded_state
from wirewear.base.engine import Engine, LocalProcesses
from wirewear.base.identity import PLANAR_CODE, Identity, added_code, identity_of
from wirewear.effects import problem_with
from wirewear.planar.model import PlanarPlan, bodies, holder_of, plan, planar_problem, require_affordable_meshes
from wirewear.planar.tables import PlanarStudy
from wirewear.results import PRESSURE_LENGTH, ContactForces, Loop, RunResult, Scar
from wirewear.simulation import NoObserver, Observer, convergence
from wirewear.simulation.contact_forces import forces_on
from wirewear.simulation.cycler import FrettingTest, Motion
from wirewear.simulation.cycling import cycle_through
from wirewear.simulation.folder import InMemory, MeshHistory, OneMesh
from wirewear.simulation.held import held_of
from wirewear.simulation.recorded import Recorded, worn_bodies
from wirewear.simulation.runs import run_planned
from wirewear.simulation.together import ObserverFor
from wirewear.study.study import alone


class PlanarRecord(Recorded):
    """The record of one run at a fidelity; `asked` is what it was asked to do, with its identity."""

    contact_kind, bodies, length_mm = "line-contact", ("specimen", "pad"), 1.0

    def __init__(self, study: PlanarStudy, fidelity: str, asked: dict[str, Any]) -> None:
        """Empty, before the run."""
        super().__init__(study, fidelity, 1e-3 * asked[PRESSURE_LENGTH])
        self.study, self._asked = study, asked

    def further_columns(self, loop: Loop, scars: tuple[Scar, Scar]) -> dict[str, float]:
        """How far the pad tilts, and where scars end."""
        ends = {
            f"{side}_edge_{scar.body}_um": edge
            for scar in scars
            for side, edge in zip(("left", "right"), scar.edges_um(), strict=True)
        }
        return {"largest_tilt_deg": float(np.abs(loop.tilt_deg).max()), **ends}

    def scars(self, problem: ContactProblem, trace: CycleTrace, cycle: int) -> tuple[Scar, Scar]:
        """Profiles with the pressure at mid-stroke."""
        specimen, pad = (
            Scar(
                cycle=cycle,
                body=name,
                diameter_mm=np.inf,
                axis_angle_deg=0.0,
                axial_um=1e3 * body.node_positions[:, 0],
                transverse_um=np.zeros(1),
                depth_um=1e3 * depth,
                energy_density_mJ_per_mm2=energy,
                pressure_MPa=(force[:, 2] / body.patch.node_areas())[:, None],
                slip_distance_um=1e3 * np.reshape(slid, depth.shape),
                length_mm=self.length_mm,
            )
            for name, (body, depth, energy, force, slid) in zip(self.bodies, worn_bodies(problem, trace), strict=True)
        )
        return specimen, pad

    def forces(self, problem: ContactProblem, trace: CycleTrace, cycle: int) -> tuple[ContactForces, ...]:
        """On specimen and pad."""
        return forces_on(problem, trace, cycle, self.study.log.contact_states, self.bodies)

    def tables(self) -> dict[str, Any]:
        """The study as it is stated."""
        return self.study.model_dump(mode="json", exclude_none=True)

    def settings(self, _history: MeshHistory) -> dict[str, Any]:
        """What it was asked to do."""
        return self._asked | self.tally.fresh | {"simulated_cycles": self.tally.counters.simulated_cycles}


#: Pictures and tables that are made of a run, relative to its folder.
DERIVED = ("report.html", "profiles.png", "loops.png", "variants.png", "profiles.csv", "loops.csv", "evolution.csv")

FIGURES = (
    convergence.Figure("largest tangential force", "N/mm", convergence.last_of("max_tangential_force_N")),
    convergence.Figure("energy of the last cycle", "mJ/mm", convergence.last_of("dissipated_energy_mJ")),
    convergence.Figure("slip amplitude δ0", "µm", convergence.last_of("slip_amplitude_um")),
    convergence.Figure("depth of the pad", "µm", convergence.last_of("max_depth_pad_um")),
    convergence.Figure("depth of the specimen", "µm", convergence.last_of("max_depth_specimen_um")),
    convergence.Figure("worn area of both bodies", "µm²", lambda result: 1e6 * float(result.worn_volume_mm3[-1])),
    convergence.Figure("half-width of the contact", "µm", convergence.last_of("contact_half_width_um")),
    *convergence.PRESSURES,
)


@dataclass(frozen=True)
class PlanarRun:
    """A study without variants, or one of its variants, at a fidelity."""

    study: PlanarStudy
    fidelity: str
    planned: PlanarPlan

    @classmethod
    def of(cls, study: PlanarStudy, fidelity: str) -> "PlanarRun":
        """The plan of a study at a fidelity; StudyError where it cannot be meshed."""
        return cls(study, fidelity, plan(study.driven.envelope, fidelity))

    @property
    def label(self) -> str:
        return self.study.variant_name or self.study.name

    @property
    def identity(self) -> Identity:
        study = self.study
        asked = {
            "study": study.model_dump(mode="json", exclude_none=True),
            "variant": study.variant_name,
            "fidelity": self.fidelity,
        }
        added = {"added": added_code((*study.effects, *study.laws))}
        return identity_of(asked, PLANAR_CODE, self.planned.settings() | added)

    @property
    def test(self) -> FrettingTest:
        study, driven, n = self.study, self.study.driven, self.planned.increments_per_cycle

        def motion(own: PlanarStudy) -> Motion:
            return Motion(
                drive=own.drive,
                increments=n,
                wear_increments=n,
                follows_force=own.mesh.increments_per_cycle is None,
                fresh=unloaded_state,
                aged=lambda problem, age: problem_with(problem, own.effects, age),
                under=lambda problem: planar_problem(own, problem.upper, problem.lower),
                held=held_of(own, own.contact.friction, holder_of(own.holder, own.conditions.normal_load_N_per_mm)),
            )

        stretches = driven.schedule.stretches
        motions = {own.block: motion(own.study) for own in stretches}
        ends = tuple((float(own.end), motions[own.block]) for own in stretches)
        milestones = tuple(float(cycle) for cycle in sorted({1, *study.log.loop_cycles, study.conditions.cycles}))
        mesh = OneMesh(lambda: planar_problem(driven, *bodies(driven, self.planned)))
        return FrettingTest(ends, mesh, milestones, self.planned.jump_tolerance, stop=study.stop)


def run_planar_study(
    study: PlanarStudy,
    *,
    fidelity: str = "standard",
    output: Path | None = None,
    resume: bool = False,
    observer: Observer | None = None,
) -> RunResult:
    """Simulate a study without variants; with `output`, leave result.h5 there.

    With `resume`, the run in `output` continues at its last checkpoint; one that is complete is left as it is.
    Raises StudyError if the study cannot be meshed, asks for more memory than there is, or has variants. Raises
    RunError if nothing can be written to `output`, or another command does; or it is to be resumed and holds another
    run. Raises SolverError if the contact did not converge, or left the fine patch; everything up to there is on disk.
    """
    study = alone(study, "run one of them, or all with run_planar_variants")
    watching = observer or NoObserver()
    if output is None:
        run = PlanarRun.of(study, fidelity)
        require_affordable_meshes(study.name, run.planned)
        return cycle_through(run.test, _record(run), InMemory(run.identity), watching, resume=False)
    (result,) = run_planar_variants(
        study, fidelity=fidelity, output=output, resume=resume, observer_of=lambda _: nullcontext(watching)
    )
    return result


def run_planar_variants(
    study: PlanarStudy,
    *,
    fidelity: str = "standard",
    output: Path,
    resume: bool = False,
    observer_of: ObserverFor | None = None,
    jobs: int = 1,
    engine: Engine | None = None,
) -> list[RunResult]:
    """Simulate a study, or each of its variants into a folder of its own; as `run_study` does with crossed wires.

    Raises as `run_planar_study`.
    """

    def engine_for(left: Sequence[PlanarRun]) -> Engine:
        for run in left:
            require_affordable_meshes(study.name, run.planned)
        return engine or LocalProcesses(max(min(jobs, len(left)), 1))

    return run_planned(
        study, PlanarRun.of, _record, fidelity, output, engine_for, DERIVED, resume=resume, observer_of=observer_of
    )


def _record(run: PlanarRun) -> PlanarRecord:
    return PlanarRecord(run.study, run.fidelity, run.planned.settings() | {"identity": str(run.identity)})


def resolutions_of(study: PlanarStudy) -> tuple[convergence.Resolution, ...]:
    """Those that a study has: without wear there are no jumps."""
    return (
        (convergence.MESH, convergence.POSITIONS, convergence.JUMPS)
        if max(study.energy_coefficients()) > 0.0
        else (convergence.MESH, convergence.POSITIONS)
    )


def refined_study(study: PlanarStudy, fidelity: str) -> PlanarStudy:
    """The study with itself and its refinements as variants.
    Raises StudyError if the study has variants of its own; choose one of them.
    """
    study = alone(study)
    tolerance, mesh = plan(study, fidelity).jump_tolerance, study.mesh

    def finer(resolution: convergence.Resolution, factor: float) -> dict[str, float]:
        return {
            convergence.MESH: {"mesh_refinement": factor * mesh.mesh_refinement},
            convergence.POSITIONS: {"increments_refinement": factor * mesh.increments_refinement},
            convergence.JUMPS: {"jump_tolerance": convergence.finer_tolerance(tolerance, factor)},
        }[resolution]

    settings = convergence.each_refined(resolutions_of(study), finer)
    refined = {name: study.model_copy(update={"mesh": mesh.model_copy(update=own)}) for name, own in settings.items()}
    return study.with_variants(tuple((name, own.named(name)) for name, own in refined.items()))


LINES = convergence.RefinedSubject(FIGURES, resolutions_of, refined_study, run_planar_variants)
