"""Runs of line contacts: the cycles and solvers are those of the wires, in plane strain."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

from solvers import unloaded_state
from wirewear.base.engine import Engine, LocalProcesses
from wirewear.base.errors import StudyError
from wirewear.base.identity import PLANAR_CODE, Identity, added_code, identity_of
from wirewear.effects import problem_with
from wirewear.planar.model import PlanarPlan, bodies, plan, planar_problem, require_affordable_meshes
from wirewear.planar.record import PlanarRecord
from wirewear.planar.tables import PlanarStudy
from wirewear.results import RunResult
from wirewear.simulation import NoObserver
from wirewear.simulation.checkpoint import OneMesh
from wirewear.simulation.convergence import (
    BASE,
    JUMPS,
    MESH,
    POSITIONS,
    PRESSURES,
    Figure,
    RefinedSubject,
    Resolution,
    each_refined,
    finer_tolerance,
    last_of,
)
from wirewear.simulation.cycler import FrettingTest, Motion
from wirewear.simulation.cycling import cycle_through
from wirewear.simulation.folder import InMemory
from wirewear.simulation.observers import Observer
from wirewear.simulation.runs import run_planned
from wirewear.simulation.together import ObserverFor

#: Pictures and tables that are made of a run, relative to its folder.
DERIVED = ("report.html", "profiles.png", "loops.png", "variants.png", "profiles.csv", "loops.csv", "evolution.csv")

FIGURES = (
    Figure("largest tangential force", "N/mm", last_of("max_tangential_force_N")),
    Figure("energy of the last cycle", "mJ/mm", last_of("dissipated_energy_mJ")),
    Figure("slip amplitude δ0", "µm", last_of("slip_amplitude_um")),
    Figure("depth of the pad", "µm", last_of("max_depth_pad_um")),
    Figure("depth of the specimen", "µm", last_of("max_depth_specimen_um")),
    Figure("worn area of both bodies", "µm²", lambda result: 1e6 * float(result.worn_volume_mm3[-1])),
    Figure("half-width of the contact", "µm", last_of("contact_half_width_um")),
    *PRESSURES,
)


@dataclass(frozen=True)
class PlanarRun:
    """A study without variants, or one of its variants, at a fidelity."""

    study: PlanarStudy
    fidelity: str
    planned: PlanarPlan

    @classmethod
    def of(cls, study: PlanarStudy, fidelity: str) -> PlanarRun:
        """The plan of a study at a fidelity; StudyError where it cannot be meshed."""
        return cls(study, fidelity, plan(study, fidelity))

    @property
    def label(self) -> str:
        """What the run is called beside others of its study."""
        return self.study.variant_name or self.study.name

    @property
    def identity(self) -> Identity:
        """Equal for runs that give the same result."""
        study = self.study
        asked = {
            "study": study.model_dump(mode="json", exclude_none=True),
            "variant": study.variant_name,
            "fidelity": self.fidelity,
        }
        added = {"added": added_code((*study.effects, study.contact.friction_law))}
        return identity_of(asked, PLANAR_CODE, self.planned.settings() | added)

    @property
    def test(self) -> FrettingTest:
        """The test as the run goes through it."""
        study, n = self.study, self.planned.increments_per_cycle
        conditions = study.conditions
        motion = Motion(
            amplitude_mm=1e-3 * conditions.displacement_amplitude_um,
            increments=n,
            wear_increments=n,
            follows_force=study.mesh.increments_per_cycle is None,
            fresh=unloaded_state,
            aged=lambda problem, age: problem_with(problem, study.effects, age),
        )
        milestones = tuple(float(cycle) for cycle in sorted({1, *study.log.loop_cycles, conditions.cycles}))
        mesh = OneMesh(lambda: planar_problem(study, *bodies(study, self.planned)))
        return FrettingTest(motion, mesh, milestones, self.planned.jump_tolerance)


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

    Raises:
        StudyError: the study cannot be meshed, asks for more memory than there is, or has variants.
        RunError: nothing can be written to `output`, or another command does; or it is to be resumed and holds another
            run.
        SolverError: the contact did not converge, or left the fine patch; everything up to there is on disk.
    """
    if study.variant_names:
        raise StudyError(f"the study {study.name!r} has variants: run one of them, or all with run_planar_variants.")
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


def resolutions_of(study: PlanarStudy) -> tuple[Resolution, ...]:
    """Those that a study has: without wear there are no jumps."""
    return (MESH, POSITIONS, JUMPS) if max(study.energy_coefficients()) > 0.0 else (MESH, POSITIONS)


def refined_study(study: PlanarStudy, fidelity: str) -> PlanarStudy:
    """The study with itself and its refinements as variants.

    Raises:
        StudyError: the study has variants of its own; choose one of them.
    """
    if study.variant_names:
        raise StudyError(f"the study {study.name!r} has variants: choose one of {', '.join(study.variant_names)}.")
    tolerance, mesh = plan(study, fidelity).jump_tolerance, study.mesh

    def finer(resolution: Resolution, factor: float) -> dict[str, float]:
        return {
            MESH: {"mesh_refinement": factor * mesh.mesh_refinement},
            POSITIONS: {"increments_refinement": factor * mesh.increments_refinement},
            JUMPS: {"jump_tolerance": finer_tolerance(tolerance, factor)},
        }[resolution]

    settings: dict[str, dict[str, float]] = {BASE: {}}
    settings |= each_refined(resolutions_of(study), finer)
    refined = {name: study.model_copy(update={"mesh": mesh.model_copy(update=own)}) for name, own in settings.items()}
    return study.with_variants(tuple((name, own.named(name)) for name, own in refined.items()))


LINES = RefinedSubject(FIGURES, resolutions_of, refined_study, run_planar_variants)
