"""Runs of line contacts: the cycles and solvers are those of the wires, in plane strain."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from pathlib import Path

from solvers import unloaded_state
from wirewear.base.engine import Engine, LocalProcesses
from wirewear.base.errors import StudyError
from wirewear.base.identity import PLANAR_CODE, Identity, added_code, identity_of
from wirewear.effects import problem_with
from wirewear.planar.model import PlanarPlan, bodies, plan, planar_problem, require_affordable_meshes
from wirewear.planar.record import PlanarRecord
from wirewear.planar.tables import PlanarStudy
from wirewear.results import RESULT_FILE_NAME, RunResult, write_result
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
from wirewear.simulation.folder import InMemory, RunFolder, RunStore
from wirewear.simulation.observers import Observer
from wirewear.simulation.together import ObserverFor, Task, run_together

#: Pictures and tables of a run, relative to its folder.
DERIVED = ("report.html", "profiles.png", "loops.png", "variants.png", "profiles.csv", "loops.csv", "evolution.csv")


#: Pictures of one run.
PICTURES = ("profiles.png", "loops.png")

#: Picture of all variants, in the folder that holds theirs.
SIDE_BY_SIDE = "variants.png"

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


def run_planar_study(
    study: PlanarStudy,
    *,
    fidelity: str = "standard",
    output: Path | None = None,
    resume: bool = False,
    observer: Observer | None = None,
) -> RunResult:
    """Simulate a study without variants; with `output`, leave result.h5, the CSV tables and the pictures there.

    With `resume`, the run in `output` continues at its last checkpoint; one that is complete is left as it is.

    Raises:
        StudyError: the study cannot be meshed, asks for more memory than there is, or has variants.
        RunError: nothing can be written to `output`, or another command does; or it is to be resumed and holds another
            run.
        SolverError: the contact did not converge, or left the fine patch; everything up to there is on disk.
    """
    if study.variant_names:
        raise StudyError(f"the study {study.name!r} has variants: run one of them, or all with run_planar_variants.")
    if output is None:
        planned = plan(study, fidelity)
        require_affordable_meshes(study.name, planned)
        store = InMemory(_identity(study, fidelity, planned))
        return _cycled(study, fidelity, planned, store, observer or NoObserver())

    def observer_of(_label: str) -> AbstractContextManager[Observer]:
        return nullcontext(observer or NoObserver())

    (result,) = run_planar_variants(study, fidelity=fidelity, output=output, resume=resume, observer_of=observer_of)
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
    variants = [study.variant(name) for name in study.variant_names] or [study]
    plans = [plan(variant, fidelity) for variant in variants]
    tasks = [
        Task(
            variant.variant_name or variant.name,
            RunFolder(
                output / variant.variant_name if study.variant_names else output,
                _identity(variant, fidelity, planned),
                _write_into,
                DERIVED,
            ),
            partial(_run_into, variant, fidelity, planned),
        )
        for variant, planned in zip(variants, plans, strict=True)
    ]

    def engine_for(left: Sequence[Task]) -> Engine:
        for task, planned in zip(tasks, plans, strict=True):
            if task in left:
                require_affordable_meshes(study.name, planned)
        return engine or LocalProcesses(max(min(jobs, len(left)), 1))

    results = run_together(
        output,
        study.name,
        tasks,
        engine_for,
        variants=bool(study.variant_names),
        resume=resume,
        observer_of=observer_of,
    )
    for task, result in zip(tasks, results, strict=True):
        # A run that was ended from outside while it drew is complete all the same.
        if not all((task.folder.path / name).exists() for name in PICTURES):
            _drawn(task.folder.path, result)
    if study.variant_names and not (resume and (output / SIDE_BY_SIDE).exists()):
        from wirewear.pictures.style import save
        from wirewear.planar.pictures import planar_variants

        save(lambda: planar_variants(results), output / SIDE_BY_SIDE)
    return results


def _run_into(
    study: PlanarStudy,
    fidelity: str,
    planned: PlanarPlan,
    folder: RunFolder,
    observer: Observer,
    *,
    resume: bool,
) -> RunResult:
    result = _cycled(study, fidelity, planned, folder, observer, resume=resume)
    _drawn(folder.path, result)
    return result


def _write_into(folder: Path, result: RunResult) -> None:
    from wirewear.results.flat import write_flat_tables

    write_result(folder / RESULT_FILE_NAME, result)
    write_flat_tables(result, folder, "csv")


def _drawn(folder: Path, result: RunResult) -> None:
    from wirewear.pictures.style import save
    from wirewear.planar.pictures import planar_drawings

    for name, draw in planar_drawings([result]).items():
        save(draw, folder / f"{name}.png")


def _cycled(
    study: PlanarStudy,
    fidelity: str,
    planned: PlanarPlan,
    store: RunStore,
    observer: Observer,
    *,
    resume: bool = False,
) -> RunResult:
    record = PlanarRecord(study, fidelity, planned.settings() | {"identity": str(store.identity)})
    return cycle_through(planar_test(study, planned), record, store, observer, resume=resume)


def _identity(study: PlanarStudy, fidelity: str, planned: PlanarPlan) -> Identity:
    asked = {
        "study": study.model_dump(mode="json", exclude_none=True),
        "variant": study.variant_name,
        "fidelity": fidelity,
    }
    added = {"added": added_code((*study.effects, study.contact.friction_law))}
    return identity_of(asked, PLANAR_CODE, planned.settings() | added)


def planar_test(study: PlanarStudy, planned: PlanarPlan) -> FrettingTest:
    """The test as a run goes through it."""
    conditions, n = study.conditions, planned.increments_per_cycle
    motion = Motion(
        amplitude_mm=1e-3 * conditions.displacement_amplitude_um,
        increments=n,
        wear_increments=n,
        follows_force=study.mesh.increments_per_cycle is None,
        fresh=unloaded_state,
        aged=lambda problem, age: problem_with(problem, study.effects, age),
    )
    milestones = tuple(float(cycle) for cycle in sorted({1, *study.log.loop_cycles, conditions.cycles}))
    return FrettingTest(
        motion, OneMesh(lambda: planar_problem(study, *bodies(study, planned))), milestones, planned.jump_tolerance
    )


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
