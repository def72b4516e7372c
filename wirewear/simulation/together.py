"""Runs of a study and its variants, of wires or line contacts: one after another, or each in a process of its own."""

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, ExitStack, nullcontext
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from queue import Empty, Queue
from threading import Event
from typing import Any, TypeVar

from wirewear.base.budget import end_with_parent
from wirewear.base.engine import Done, Engine, LocalProcesses, results_of
from wirewear.base.errors import LostTaskError, RunError
from wirewear.base.writing import prepared_folder
from wirewear.results import RESULT_FILE_NAME, RunResult
from wirewear.simulation.folder import Found, RunFolder, occupied_by_runs
from wirewear.simulation.observers import Moment, Observer

_POLL_s = 0.1

LOST_PROCESS = (
    "a process that simulated was ended from outside, perhaps because memory ran out: --resume goes on, with fewer "
    "--jobs in less memory."
)

Made = TypeVar("Made")

ObserverFor = Callable[[str], AbstractContextManager[Observer]]


@dataclass(frozen=True)
class RemoteObserver(Observer):
    """Sends what a run tells it to the process that watches."""

    index: int
    mailbox: Queue[Any]

    def stage(self, text: str) -> None:
        """Pass on that a part of the preparation begins."""
        self._send("stage", text)

    def moved(self, moment: Moment) -> None:
        """Pass on that an increment is done."""
        self._send("moved", moment)

    def logged(self, result: object) -> None:
        """Pass on what is on disk."""
        self._send("logged", result)

    def note(self, sentence: str) -> None:
        """Pass on what the user should know."""
        self._send("note", sentence)

    def _send(self, kind: str, item: object) -> None:
        self.mailbox.put((self.index, kind, item))


def run_side_by_side(
    tasks: Sequence[Callable[[Observer], Made]], observers: Sequence[Observer], engine: Engine
) -> list[Made]:
    """Do tasks side by side; each is called with an observer that reports to its own of `observers`.

    Workers of a cluster report nothing: they may be anywhere. When a task fails, the others still come to their end;
    then the first error is raised.
    """
    if not isinstance(engine, LocalProcesses):
        return results_of(engine, [partial(task, Observer()) for task in tasks])
    from multiprocessing.managers import SyncManager

    manager = SyncManager(ctx=multiprocessing.get_context("spawn"))
    manager.start(end_with_parent)
    with manager, ThreadPoolExecutor(1) as waiting:
        mailbox = manager.Queue()
        told = [partial(task, RemoteObserver(index, mailbox)) for index, task in enumerate(tasks)]
        stop = Event()
        every = waiting.submit(_done_until, stop, engine, told)
        try:
            while not every.done():
                _deliver(mailbox, observers)
        finally:
            # Interrupted: what runs ends, what waits is not begun.
            stop.set()
        _deliver(mailbox, observers)
        try:
            return [one.value() for one in every.result()]
        except LostTaskError as error:
            raise RunError(LOST_PROCESS) from error


def _done_until(stop: Event, engine: Engine, tasks: Sequence[Callable[[], Made]]) -> list[Done[Made]]:
    """All tasks in their order, or those that were done when it was to stop."""
    every = []
    for one in engine.done(tasks):
        every.append(one)
        if stop.is_set():
            break
    return sorted(every, key=lambda one: one.place)


def _deliver(mailbox: Queue[Any], observers: Sequence[Observer]) -> None:
    try:
        while True:
            index, kind, item = mailbox.get(timeout=_POLL_s)
            getattr(observers[index], kind)(item)
    except Empty:
        return


@dataclass(frozen=True)
class Task:
    """One run of a study.

    label: what it is called beside others.  simulate: does it in a folder, watched by an observer; can be sent to
    another process.  prepare: does what runs side by side would all have to do, such as meshes that they share; is told
    of each part.
    """

    label: str
    folder: RunFolder
    simulate: Callable[..., RunResult]
    prepare: Callable[[Callable[[str], None]], None]


def run_together(
    output: Path,
    name: str,
    tasks: Sequence[Task],
    engine_for: Callable[[Sequence[Task]], Engine],
    *,
    variants: bool,
    resume: bool,
    observer_of: ObserverFor | None = None,
) -> list[RunResult]:
    """The results of the runs of a study, in their order; those that are complete and resumed are read.

    variants: whether they are variants, each in a folder of its own within `output`.  engine_for: says what does the
    runs that are left.
    Raises RunError if another command is writing to the folder, or it cannot be written, or holds other runs. Raises
    ResultError if what a run has left is damaged, or a file cannot be written. Raises SolverError if a contact did not
    converge, or left the fine patch; everything up to there is on disk.
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


def _nobody(_label: str) -> AbstractContextManager[Observer]:
    return nullcontext(Observer())


def _run_all(
    runs: Sequence[tuple[Task, Found]], observer_of: ObserverFor, engine: Engine, *, resume: bool
) -> list[RunResult]:
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
            task.prepare(watchers[0].stage)
        tasks = [partial(task.simulate, task.folder, resume=resume) for task, _ in runs]
        return run_side_by_side(tasks, watchers, engine)


def _tell(found: Found, observer: Observer) -> None:
    if found.note:
        observer.note(found.note)
