"""Engines do tasks that do not depend on one another and hand over each as it is done; one uses this machine."""

import multiprocessing
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from math import inf
from typing import Generic, TypeVar

from wirewear.base.cache import WARNED, cache_directory
from wirewear.base.errors import EngineError, LostTaskError, tell_plainly
from wirewear.base.processes import end_with_parent
from wirewear.base.writing import writing

Result = TypeVar("Result")

LOST_PROCESS = (
    "a process at work was ended from outside, perhaps because memory ran out: the same command goes on, with fewer "
    "--jobs in less memory."
)

TASKS_PER_PROCESS = 20  #: New processes now and then: what libraries keep of one task does not add up over a night.


@dataclass(frozen=True)
class Done(Generic[Result]):
    """A task that came to its end: `place` among the tasks, and what it returned, or what it raised."""

    place: int
    result: Result | None = None
    error: BaseException | None = None

    def value(self) -> Result:
        """What it returned; raises what it raised."""
        if self.error is not None:
            raise self.error
        return self.result  # type: ignore[return-value]


class Engine(ABC):
    """Does tasks, each in a process that does nothing else meanwhile.

    A task is a function without arguments that can be pickled, as can what it returns. When its process is lost, it is
    begun once more; it is handed over once, however often it was begun.
    """

    #: In a message: what the engine works with.
    words: str

    @property
    @abstractmethod
    def workers(self) -> int:
        """How many tasks it does at a time. Raises EngineError if there is nobody to do them."""

    @contextmanager
    def held(self) -> Iterator[None]:
        """Within, what is needed to reach those that do the tasks is set up once and kept."""
        yield

    @abstractmethod
    def done(self, tasks: Sequence[Callable[[], Result]], until: float = inf) -> Iterator[Done[Result]]:
        """Every task as it comes to its end; none is begun after `until` (of time.monotonic).

        When the caller stops asking, those that run come to their end, and no other is begun.
        Raises EngineError if the cluster cannot be reached, or runs another program.
        """


def results_of(engine: Engine, tasks: Sequence[Callable[[], Result]]) -> list[Result]:
    """What the tasks return, in their order; raises the first error that one of them raised, once all are done."""
    every = sorted(engine.done(tasks), key=lambda one: one.place)
    return [one.value() for one in every]


class LocalProcesses(Engine):
    """Up to `jobs` processes, which end with the one that started them."""

    words = "processes of this machine"

    def __init__(self, jobs: int, tasks_per_process: int = TASKS_PER_PROCESS) -> None:
        """Nothing is started before it is needed."""
        self._jobs = jobs
        self._tasks_per_process = tasks_per_process

    @property
    def workers(self) -> int:
        """The number of processes."""
        return self._jobs

    def done(self, tasks: Sequence[Callable[[], Result]], until: float = inf) -> Iterator[Done[Result]]:
        """Every task as it comes to its end; see `Engine.done`."""
        lost: list[int] = []
        waiting = deque(range(len(tasks)))
        while waiting:
            lost += yield from self._until_lost(tasks, waiting, self._jobs, until)
        # A broken pool does not tell whose process was lost: those that ran are repeated one by one.
        for place in sorted(lost):
            again = yield from self._until_lost(tasks, deque([place]), 1, until)
            if again:
                yield Done(place, error=LostTaskError(LOST_PROCESS))

    def _until_lost(
        self, tasks: Sequence[Callable[[], Result]], waiting: deque[int], jobs: int, until: float
    ) -> Generator[Done[Result], None, list[int]]:
        """Hands over tasks until none is waiting or a process is lost; returns the places of those that were lost."""
        cache_directory()  # where there is none, this process says so, for all
        # Threads of the parent's libraries do not survive a fork.
        context = multiprocessing.get_context("spawn")
        running: dict[Future[Result], int] = {}
        with writing(EngineError, "no processes can be started, for which semaphores are made in /dev/shm"):
            begun = ProcessPoolExecutor(
                jobs, context, _begin, (frozenset(WARNED),), max_tasks_per_child=self._tasks_per_process
            )
        with begun as pool:
            lost: list[int] = []
            while (waiting or running) and not lost:
                while waiting and len(running) < jobs and time.monotonic() < until:
                    try:
                        running[pool.submit(tasks[waiting[0]])] = waiting[0]
                    except BrokenProcessPool:
                        break
                    waiting.popleft()
                if not running:
                    waiting.clear()
                    return lost
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    place = running.pop(future)
                    error = future.exception()
                    if isinstance(error, BrokenProcessPool):
                        lost.append(place)
                    else:
                        yield Done(place, None if error else future.result(), error)
            for future, place in running.items():
                error = future.exception()
                if isinstance(error, BrokenProcessPool):
                    lost.append(place)
                else:
                    yield Done(place, None if error else future.result(), error)
            return lost


def _begin(warned: frozenset[str]) -> None:
    """What a process does before its tasks; its user has been warned of that already."""
    end_with_parent()
    tell_plainly()
    WARNED.update(warned)
