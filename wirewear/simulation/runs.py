"""Runs of a study: one, or one for each of its variants, one after another or side by side."""

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, ExitStack, nullcontext
from dataclasses import dataclass, replace
from functools import partial, singledispatch
from pathlib import Path
from queue import Empty, Queue
from threading import Event
from typing import Any, TypeVar

from wirewear.base.engine import Done, Engine, LocalProcesses, end_with_parent, results_of
from wirewear.base.errors import LostTaskError, RunError, StudyError
from wirewear.base.memory import free_memory
from wirewear.base.writing import prepared_folder
from wirewear.results import RESULT_FILE_NAME, RunResult
from wirewear.simulation.cycling import cycle_through
from wirewear.simulation.line_runs import LineRun
from wirewear.simulation.near_zone import NEAR_ZONE
from wirewear.simulation.observers import Moment, Observer
from wirewear.simulation.point_runs import PointRun
from wirewear.simulation.store import Found, RunFolder, RunStore, occupied_by_runs
from wirewear.simulation.yielding import limit_of_points
from wirewear.test import AnyStudy, LineStudy, Study
from wirewear.test.any_study import alone

LOST_PROCESS = (
    "a process that simulated was ended from outside, perhaps because memory ran out: --resume goes on, with fewer "
    "--jobs in less memory."
)

Made = TypeVar("Made")

ObserverOf = Callable[[str], AbstractContextManager[Observer]]


@dataclass(frozen=True)
class RemoteObserver(Observer):
    """Sends what a run reports to the process that watches it, with the run's index, through `mailbox`."""

    index: int
    mailbox: Queue[Any]

    def stage(self, text: str) -> None:
        self._send("stage", text)

    def moved(self, moment: Moment) -> None:
        self._send("moved", moment)

    def logged(self, result: object) -> None:
        self._send("logged", result)

    def note(self, sentence: str) -> None:
        self._send("note", sentence)

    def _send(self, kind: str, item: object) -> None:
        self.mailbox.put((self.index, kind, item))


def run_side_by_side(
    tasks: Sequence[Callable[[Observer], Made]], observers: Sequence[Observer], engine: Engine
) -> list[Made]:
    """The tasks' results, in their order, done side by side on `engine`; each task is called with an observer that
    reports to its own one of `observers`. Workers of a cluster report nothing. If a task fails, the others are still
    finished; then the first error is raised. Raises RunError if a process was ended from outside.
    """
    if not isinstance(engine, LocalProcesses):
        return results_of(engine, [partial(task, Observer()) for task in tasks])
    from multiprocessing.managers import SyncManager

    manager = SyncManager(ctx=multiprocessing.get_context("spawn"))
    manager.start(end_with_parent)
    with manager, ThreadPoolExecutor(1) as waiting:
        mailbox = manager.Queue()
        observed = [partial(task, RemoteObserver(index, mailbox)) for index, task in enumerate(tasks)]
        stop = Event()
        every = waiting.submit(_done_until, stop, engine, observed)
        try:
            while not every.done():
                _deliver(mailbox, observers)
        finally:
            # Interrupted: what runs ends, what waits does not start.
            stop.set()
        _deliver(mailbox, observers)
        try:
            return [one.value() for one in every.result()]
        except LostTaskError as error:
            raise RunError(LOST_PROCESS) from error


def _done_until(stop: Event, engine: Engine, tasks: Sequence[Callable[[], Made]]) -> list[Done[Made]]:
    """The results of tasks in their order; only those done so far if `stop` is set."""
    every = []
    for one in engine.done(tasks):
        every.append(one)
        if stop.is_set():
            break
    return sorted(every, key=lambda one: one.place)


def _deliver(mailbox: Queue[Any], observers: Sequence[Observer]) -> None:
    try:
        while True:
            index, kind, item = mailbox.get(timeout=0.1)
            getattr(observers[index], kind)(item)
    except Empty:
        return


def files_of_runs(study: AnyStudy) -> tuple[str, ...]:
    """Patterns of the files that a run of the study writes or removes in its folder."""
    return (RESULT_FILE_NAME, *(LineRun if isinstance(study, LineStudy) else PointRun).derived)


@dataclass(frozen=True)
class Task:
    """One run of a study: its label, its folder, and how it is prepared and simulated. simulate: from folder, observer
    and `resume` to the result; can be sent to another process. prepare: makes what runs share, such as meshes, and
    calls its argument with the name of each part.
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
    observer_of: ObserverOf | None = None,
) -> list[RunResult]:
    """The results of the runs of a study, in the order of `tasks`.

    name: the study's, for messages. variants: True if each task has a folder of its own in `output`. engine_for: gives
    the engine for the tasks that remain. resume: read complete results and go on from checkpoints. observer_of: opens a
    run's observer by its label; None reports nothing.

    Raises RunError if another command is writing to the folder, or it cannot be written, or holds other runs;
    ResultError if what a run has left is damaged, or a file cannot be written; SolverError if a contact did not
    converge, or left the fine patch. Everything up to there is on disk.
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
    runs: Sequence[tuple[Task, Found]], observer_of: ObserverOf, engine: Engine, *, resume: bool
) -> list[RunResult]:
    if isinstance(engine, LocalProcesses) and (engine.workers == 1 or len(runs) <= 1):
        results = []
        for task, found in runs:
            with observer_of(task.label) as observer:
                _report(found, observer)
                results.append(task.simulate(task.folder, observer, resume=resume))
        return results
    with ExitStack() as stack:
        watchers = [stack.enter_context(observer_of(task.label)) for task, _ in runs]
        for (task, found), watcher in zip(runs, watchers, strict=True):
            _report(found, watcher)
            task.prepare(watchers[0].stage)
        tasks = [partial(task.simulate, task.folder, resume=resume) for task, _ in runs]
        return run_side_by_side(tasks, watchers, engine)


def _report(found: Found, observer: Observer) -> None:
    if found.note:
        observer.note(found.note)


@singledispatch
def plan_of(study: AnyStudy, fidelity: str) -> PointRun | LineRun:
    """The planned run of a study without variants. Raises StudyError if it cannot be discretised, or is of a kind
    without bodies to simulate.
    """
    del fidelity
    raise StudyError(f"the study {study.name!r} is of kind {study.kind!r}, which has no bodies to simulate.")


@plan_of.register
def _(study: Study, fidelity: str) -> PointRun:
    return PointRun.of(study, fidelity)


@plan_of.register
def _(study: LineStudy, fidelity: str) -> LineRun:
    return LineRun.of(study, fidelity)


def run_study(
    study: AnyStudy,
    *,
    fidelity: str = "standard",
    output: str | Path,
    resume: bool = False,
    observer_of: ObserverOf | None = None,
    jobs: int = 1,
    engine: Engine | None = None,
) -> list[RunResult]:
    """Simulate a study of any kind, or each of its variants, and leave OUTPUT[/<variant>]/result.h5; return the
    results.

    `observer_of` opens an observer for each run by its label. With `resume`, a run continues at its last checkpoint,
    and a complete one is read from its file; one that another version of the program made is run again, and the
    observer is informed. With `jobs` above 1, that many variants run side by side, each in a process of its own, or on
    the workers of `engine`, which must see the folder; the results are the same.

    Raises StudyError if the study cannot be discretised, or needs more memory or cycle jumps than are allowed; RunError
    if a run is to be resumed but the folder holds another study's, or if another command is writing to the folder, or
    it cannot be written; ResultError if a run is to be resumed but its files are damaged, or if a file cannot be
    written; SolverError if the contact did not converge, or left the fine patch. Everything up to there is on disk.
    """
    output = Path(output)
    variants = [study.variant(name) for name in study.variant_names] or [study]
    plans = [plan_of(variant, fidelity) for variant in variants]
    tasks = [
        Task(
            plan.label,
            RunFolder(plan.identity, output / plan.study.variant_name if study.variant_names else output, plan.derived),
            partial(run_cycles, plan),
            plan.prepare,
        )
        for plan in plans
    ]
    plan_in = {task.folder.path: plan for task, plan in zip(tasks, plans, strict=True)}

    def engine_for(left: Sequence[Task]) -> Engine:
        due = [plan_in[task.folder.path] for task in left]
        for plan in due:
            plan.require_affordable()
        largest = max((plan.needed_memory for plan in due), default=1.0)
        return engine or LocalProcesses(max(1, min(jobs, len(due), int(min(free_memory() / largest, 1e6)))))

    return run_together(
        output,
        study.name,
        tasks,
        engine_for,
        variants=bool(study.variant_names),
        resume=resume,
        observer_of=observer_of,
    )


def simulate(study: AnyStudy, *, fidelity: str = "standard", observer: Observer | None = None) -> RunResult:
    """Simulate a study without variants, or one variant, and return its result; no file is written.

    Raises StudyError if it has variants, cannot be discretised, or needs more memory or cycle jumps than are allowed;
    SolverError if the contact did not converge, or left the fine patch.
    """
    plan = plan_of(alone(study, 'take one of them, as in study.variant("{first}")'), fidelity)
    plan.require_affordable()
    return run_cycles(plan, RunStore(plan.identity), observer or Observer(), resume=False)


def needed_memory(study: AnyStudy, fidelity: str) -> float:
    """Bytes that the run of a study without variants takes at least; StudyError if it cannot be discretised."""
    return float(plan_of(study, fidelity).needed_memory)


def run_cycles(plan: PointRun | LineRun, folder: RunStore, observer: Observer, *, resume: bool) -> RunResult:
    """Simulate a planned run in its folder, with `resume` from its checkpoint; raises what `cycle_through` does."""
    if isinstance(plan, PointRun) and plan.study.contact.plasticity == NEAR_ZONE and limit_of_points(plan.study):
        observer.note(f"{plan.study.name}: pressing metal that flows, and sliding it through its first cycles")
    return cycle_through(plan.test, plan.recorder(), folder, observer, resume=resume)
