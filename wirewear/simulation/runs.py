"""Runs of a study: one, or one for each of its variants, one after another or side by side."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, ExitStack, nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from wirewear.files import prepared_folder
from wirewear.files.identity import Identity
from wirewear.results import RESULT_FILE_NAME, RunResult, read_result, write_result
from wirewear.results.vtk import TIME_SERIES_FILES
from wirewear.simulation.budget import affordable_jobs, require_affordable
from wirewear.simulation.cycling import cycle_through
from wirewear.simulation.folder import Found, RunFolder, occupied_by_runs
from wirewear.simulation.observers import NoObserver, RunObserver
from wirewear.simulation.plan import RunPlan
from wirewear.simulation.problem import condense_wires
from wirewear.simulation.record import WireRecord
from wirewear.simulation.side_by_side import run_side_by_side
from wirewear.study import Study

#: What `wirewear show` draws of a run, relative to its folder; spelled here, as drawing takes long to import.
PICTURES = tuple(
    f"pictures/{name}.png"
    for name in ("loops", "evolution", "scars_from_above", "contact*", "scar_series*", "sections", "scars_3d")
)

ObserverOf = Callable[[str], AbstractContextManager[RunObserver]]


def run_study(
    study: Study,
    *,
    fidelity: str = "standard",
    output: Path,
    resume: bool = False,
    observer_of: ObserverOf | None = None,
    jobs: int = 1,
) -> list[RunResult]:
    """Simulate a study, or each of its variants, and leave OUTPUT[/<variant>]/result.h5.

    `observer_of` opens an observer for each run by its label. With `resume`, a run continues at its last checkpoint,
    and one that is complete is read from its file and left as it is; one that another version of the program made is
    run anew, of which the observer is told. With `jobs` above 1, that many variants run side
    by side, each in a process of its own; the results are the same.

    Raises:
        StudyError: the study cannot be discretised, or asks for more memory or cycle jumps than can be had.
        RunError: a run is to be resumed, but the folder holds that of another study; or another command is writing to
            the folder, or it cannot be written.
        ResultError: a run is to be resumed, but what it has left is damaged; or a file cannot be written.
        SolverError: the contact did not converge, or left the fine patch; everything up to there is on disk.
    """
    variants = [study.variant(name) for name in study.variant_names] or [study]
    plans = [RunPlan.of(variant, fidelity) for variant in variants]
    folders = [
        run_folder(output / plan.study.variant_name if study.variant_names else output, plan.identity) for plan in plans
    ]
    with occupied_by_runs(output, study.name, folders, resume=resume) as found:
        if study.variant_names and not resume:
            # What a run without variants has left there.
            (output / RESULT_FILE_NAME).unlink(missing_ok=True)
            run_folder(output, plans[0].identity).begin()
        left = [_Left(*one) for one in zip(plans, folders, found, strict=True) if one[2].complete is None]
        for one in left:
            require_affordable(one.plan)
        for one in left:
            prepared_folder(one.folder.path)
        jobs = affordable_jobs([one.plan for one in left], jobs)
        simulated = iter(_run_all(left, observer_of or _nobody, jobs, resume=resume))
        return [next(simulated) if one.complete is None else one.complete for one in found]


@dataclass(frozen=True)
class _Left:
    """A run that is not complete."""

    plan: RunPlan
    folder: RunFolder[RunResult]
    found: Found[RunResult]


def run_folder(path: Path, identity: Identity) -> RunFolder[RunResult]:
    """The folder of a run of crossed wires."""
    return RunFolder(path, identity, read_result, _write_into, (*TIME_SERIES_FILES, *PICTURES))


def _write_into(folder: Path, result: RunResult) -> None:
    write_result(folder / RESULT_FILE_NAME, result)


def run_cycles(plan: RunPlan, folder: RunFolder[RunResult], observer: RunObserver, *, resume: bool) -> RunResult:
    """Simulate a run, from its last checkpoint on where it is to be resumed and has one; raises as `cycle_through`."""
    return cycle_through(plan.test, WireRecord(plan), folder, observer, resume=resume)


def _nobody(_label: str) -> AbstractContextManager[RunObserver]:
    return nullcontext(NoObserver())


def _run_all(runs: Sequence[_Left], observer_of: ObserverOf, jobs: int, *, resume: bool) -> list[RunResult]:
    if jobs <= 1 or len(runs) <= 1:
        results = []
        for run in runs:
            with observer_of(run.plan.label) as observer:
                _tell(run, observer)
                results.append(run_cycles(run.plan, run.folder, observer, resume=resume))
        return results
    with ExitStack() as stack:
        watchers = [stack.enter_context(observer_of(run.plan.label)) for run in runs]
        # Variants mostly share their wires: condensed once here, they are loaded by every process.
        for run, watcher in zip(runs, watchers, strict=True):
            _tell(run, watcher)
            for stage in run.plan.meshes.stages:
                condense_wires(run.plan.study, stage, watchers[0].stage)
        tasks = [partial(run_cycles, run.plan, run.folder, resume=resume) for run in runs]
        return run_side_by_side(tasks, watchers, min(jobs, len(tasks)))


def _tell(run: _Left, observer: RunObserver) -> None:
    if run.found.note:
        observer.note(run.found.note)
