"""Runs of a study and its variants, of wires or line contacts: one after another, or each in a process of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, ExitStack, nullcontext
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Generic, Protocol

from wirewear.engine import Engine, LocalProcesses
from wirewear.files import prepared_folder
from wirewear.results import RESULT_FILE_NAME
from wirewear.simulation.folder import Found, Result, RunFolder, occupied_by_runs
from wirewear.simulation.observers import NoObserver, Observer
from wirewear.simulation.side_by_side import run_side_by_side


class Simulates(Protocol[Result]):
    """Simulates a run into its folder; can be sent to another process."""

    def __call__(self, folder: RunFolder[Result], observer: Observer[Result], /, *, resume: bool) -> Result:
        """The result."""


@dataclass(frozen=True)
class Task(Generic[Result]):
    """One run of a study.

    label: what it is called beside others.  simulate: does it.  prepare: does what runs side by side would all have to
    do, such as meshes that they share; is told of each part.
    """

    label: str
    folder: RunFolder[Result]
    simulate: Simulates[Result]
    prepare: Callable[[Callable[[str], None]], None] | None = None


ObserverFor = Callable[[str], AbstractContextManager[Observer[Result]]]


def run_together(
    output: Path,
    name: str,
    tasks: Sequence[Task[Result]],
    engine_for: Callable[[Sequence[Task[Result]]], Engine],
    *,
    variants: bool,
    resume: bool,
    observer_of: ObserverFor[Result] | None = None,
) -> list[Result]:
    """The results of the runs of a study, in their order; those that are complete and resumed are read.

    variants: whether they are variants, each in a folder of its own within `output`.  engine_for: says what does the
    runs that are left.

    Raises:
        RunError: another command is writing to the folder, or it cannot be written, or holds other runs.
        ResultError: what a run has left is damaged; or a file cannot be written.
        SolverError: a contact did not converge, or left the fine patch; everything up to there is on disk.
    """
    with occupied_by_runs(output, name, [task.folder for task in tasks], resume=resume) as found:
        if variants and not resume:
            # What a run without variants has left there.
            (output / RESULT_FILE_NAME).unlink(missing_ok=True)
            replace(tasks[0].folder, path=output).begin()
        left = [(task, one) for task, one in zip(tasks, found, strict=True) if one.complete is None]
        engine = engine_for([task for task, _ in left])
        for task, _ in left:
            prepared_folder(task.folder.path)
        simulated = iter(_run_all(left, observer_of or _nobody, engine, resume=resume))
        return [next(simulated) if one.complete is None else one.complete for one in found]


def _nobody(_label: str) -> AbstractContextManager[Observer[Result]]:
    return nullcontext(NoObserver())


def _run_all(
    runs: Sequence[tuple[Task[Result], Found[Result]]],
    observer_of: ObserverFor[Result],
    engine: Engine,
    *,
    resume: bool,
) -> list[Result]:
    if isinstance(engine, LocalProcesses) and (engine.workers == 1 or len(runs) <= 1):
        results = []
        for task, found in runs:
            with observer_of(task.label) as observer:
                _tell(found, observer)
                results.append(task.simulate(task.folder, observer, resume=resume))
        return results
    with ExitStack() as stack:
        watchers = [stack.enter_context(observer_of(task.label)) for task, _ in runs]
        for (task, found), watcher in zip(runs, watchers, strict=True):
            _tell(found, watcher)
            if task.prepare is not None:
                task.prepare(watchers[0].stage)
        tasks = [partial(task.simulate, task.folder, resume=resume) for task, _ in runs]
        return run_side_by_side(tasks, watchers, engine)


def _tell(found: Found[Result], observer: Observer[Result]) -> None:
    if found.note:
        observer.note(found.note)
