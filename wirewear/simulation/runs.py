"""Runs of a study: one, or one for each of its variants, one after another or side by side."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack, nullcontext
from functools import partial
from pathlib import Path

from wirewear.files import prepared_folder
from wirewear.results import RESULT_FILE_NAME, RunResult, read_result, write_result
from wirewear.simulation.cycling import cycle_through
from wirewear.simulation.folder import RunFolder
from wirewear.simulation.observers import NoObserver, RunObserver
from wirewear.simulation.plan import RunPlan
from wirewear.simulation.problem import condense_wires
from wirewear.simulation.record import WireRecord
from wirewear.simulation.side_by_side import run_side_by_side
from wirewear.study import Study

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
    and one that is complete is read from its file and left as it is. With `jobs` above 1, that many variants run side
    by side, each in a process of its own; the results are the same.

    Raises:
        StudyError: the study cannot be discretised.
        RunError: a run is to be resumed, but the folder holds that of another study; or a folder cannot be written.
        SolverError: the contact did not converge, or left the fine patch; everything up to there is on disk.
    """
    variants = [study.variant(name) for name in study.variant_names] or [study]
    plans = [RunPlan.of(variant, fidelity) for variant in variants]
    folders = [
        run_folder(output / plan.study.variant_name if study.variant_names else output, plan.identity) for plan in plans
    ]
    complete = [folder.complete_result() if resume else None for folder in folders]
    left = [(plan, folder) for plan, folder, result in zip(plans, folders, complete, strict=True) if result is None]
    for _, folder in left:
        prepared_folder(folder.path)
    simulated = iter(_run_all(left, observer_of or _nobody, jobs, resume=resume))
    return [next(simulated) if result is None else result for result in complete]


def run_folder(path: Path, identity: str) -> RunFolder[RunResult]:
    """The folder of a run of crossed wires."""
    return RunFolder(path, identity, read_result, _write_into)


def _write_into(folder: Path, result: RunResult) -> None:
    write_result(folder / RESULT_FILE_NAME, result)


def run_cycles(plan: RunPlan, folder: RunFolder[RunResult], observer: RunObserver, *, resume: bool) -> RunResult:
    """Simulate a run, from its last checkpoint on where it is to be resumed and has one; raises as `cycle_through`."""
    return cycle_through(plan.test, WireRecord(plan), folder, observer, resume=resume)


def _nobody(_label: str) -> AbstractContextManager[RunObserver]:
    return nullcontext(NoObserver())


def _run_all(
    runs: list[tuple[RunPlan, RunFolder[RunResult]]], observer_of: ObserverOf, jobs: int, *, resume: bool
) -> list[RunResult]:
    if jobs <= 1 or len(runs) <= 1:
        results = []
        for plan, folder in runs:
            with observer_of(plan.label) as observer:
                results.append(run_cycles(plan, folder, observer, resume=resume))
        return results
    with ExitStack() as stack:
        watchers = [stack.enter_context(observer_of(plan.label)) for plan, _ in runs]
        # Variants mostly share their wires: condensed once here, they are loaded by every process.
        for plan, _ in runs:
            for stage in plan.meshes.stages:
                condense_wires(plan.study, stage, watchers[0].stage)
        tasks = [partial(run_cycles, plan, folder, resume=resume) for plan, folder in runs]
        return run_side_by_side(tasks, watchers, min(jobs, len(tasks)))
