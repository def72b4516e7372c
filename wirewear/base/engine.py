"""Engines compute independent tasks in parallel, on this machine or on a cluster, and yield each when it is done."""

from __future__ import annotations

import multiprocessing
import os
import sys
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence, Set
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from math import inf
from multiprocessing import connection
from multiprocessing.process import BaseProcess
from secrets import token_hex
from threading import Thread
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from wirewear.base.cache import WARNED, cache_directory, code_hash
from wirewear.base.errors import EngineError, LostTaskError, show_warnings_plainly
from wirewear.base.writing import writing

Result = TypeVar("Result")

LOST_PROCESS = (
    "a process at work was ended from outside, perhaps because memory ran out: the same command goes on, with fewer "
    "--jobs in less memory."
)

PATIENCE_s = 20.0  #: How long a scheduler may take to answer, and its first worker to come.


@dataclass(frozen=True)
class Done(Generic[Result]):
    """A task that has ended: its index `place` among the tasks, and its result or the error that it raised."""

    place: int
    result: Result | None = None
    error: BaseException | None = None

    def value(self) -> Result:
        """Result of the task; raises the error that the task raised."""
        if self.error is not None:
            raise self.error
        return self.result  # type: ignore[return-value]


class Engine(ABC):
    """Computes tasks in parallel, each in a process that does nothing else meanwhile.

    A task is a function without arguments that can be pickled, as must its result. If its process is lost it is started
    once more; its result is yielded once.
    """

    #: Words for messages on where tasks are computed.
    words: str

    @property
    @abstractmethod
    def workers(self) -> int:
        """Number of tasks computed at the same time. Raises EngineError if there are no workers."""

    @contextmanager
    def held(self) -> Iterator[None]:
        """Keep the connection to the workers open within this context; without it each `done` opens its own."""
        yield

    @abstractmethod
    def done(self, tasks: Sequence[Callable[[], Result]], until: float = inf) -> Iterator[Done[Result]]:
        """Yield each task once it has ended, in the order of their ends; no task starts after the time `until` (of
        time.monotonic).

        If the caller stops iterating, running tasks end and no other starts; an interruption ends those of this machine
        at once. Raises EngineError if the cluster cannot be reached, or runs another program.
        """


def results_of(engine: Engine, tasks: Sequence[Callable[[], Result]]) -> list[Result]:
    """Results of the tasks in their order; if tasks raised errors, the first is raised after all tasks have ended."""
    every = sorted(engine.done(tasks), key=lambda one: one.place)
    return [one.value() for one in every]


class LocalProcesses(Engine):
    """Engine with up to `jobs` processes on this machine, which end when the parent process ends.

    Each process is replaced after `tasks_per_process` tasks, so that memory kept by libraries does not add up. None is
    started before `done`.
    """

    words = "processes of this machine"

    def __init__(self, jobs: int, tasks_per_process: int = 20) -> None:
        self._jobs = jobs
        self._tasks_per_process = tasks_per_process

    @property
    def workers(self) -> int:
        return self._jobs

    def done(self, tasks: Sequence[Callable[[], Result]], until: float = inf) -> Iterator[Done[Result]]:
        lost: list[int] = []
        waiting = deque(range(len(tasks)))
        while waiting:
            lost += yield from self._until_lost(tasks, waiting, self._jobs, until)
        # A broken pool does not show whose process was lost: those that ran are repeated one by one.
        for place in sorted(lost):
            again = yield from self._until_lost(tasks, deque([place]), 1, until)
            if again:
                yield Done(place, error=LostTaskError(LOST_PROCESS))

    def _until_lost(
        self, tasks: Sequence[Callable[[], Result]], waiting: deque[int], jobs: int, until: float
    ) -> Generator[Done[Result], None, list[int]]:
        """Yield ended tasks until none is waiting or a process is lost; returns the indices of the lost tasks.

        Indices are taken from `waiting`, which is changed in place.
        """
        cache_directory()  # where there is none, this process says so, for all
        # Threads of the parent's libraries do not survive a fork.
        context = multiprocessing.get_context("spawn")
        running: dict[Future[Result], int] = {}
        with writing(EngineError, "no processes can be started, for which semaphores are made in /dev/shm"):
            pool = ProcessPoolExecutor(
                jobs, context, _begin, (frozenset(WARNED),), max_tasks_per_child=self._tasks_per_process
            )
        others = set(multiprocessing.active_children())
        with pool, _ended_if_interrupted(others):
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
                # A signal that another thread has taken is heard of between two waits.
                for future in wait(running, timeout=1.0, return_when=FIRST_COMPLETED).done:
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


@contextmanager
def _ended_if_interrupted(others: Set[BaseProcess]) -> Iterator[None]:
    """End this process' children but `others` if the enclosed work is interrupted: nobody waits for what they make."""
    try:
        yield
    except KeyboardInterrupt:
        for process in set(multiprocessing.active_children()) - others:
            process.kill()  # as it may ignore a request to end
        raise


def _begin(warned: frozenset[str]) -> None:
    """Set up a new process before its tasks; warnings in `warned` were already shown to the user."""
    end_with_parent()
    show_warnings_plainly()
    WARNED.update(warned)


if TYPE_CHECKING:
    from distributed import Client


def engine_of(jobs: int | None = None, scheduler: str | None = None) -> Engine:
    """The engine for a number of jobs on this machine (None: one for each core) or, if it is given, for the cluster
    with this scheduler's address.
    """
    if scheduler is not None:
        return DaskCluster(scheduler)
    return LocalProcesses(jobs or os.cpu_count() or 1)


class DaskCluster(Engine):
    """Engine on a Dask cluster, given by the address of its scheduler, such as tcp://10.0.0.1:8786. It is contacted
    when first used.

    Its workers must run the same program with one thread each, as gmsh handles one mesh per process.
    """

    def __init__(self, address: str) -> None:
        self.address = address
        self.words = f"the Dask cluster at {address}"
        self._kept: Client | None = None

    @property
    def workers(self) -> int:
        with self._client() as client:
            return len(_workers(client))

    def done(self, tasks: Sequence[Callable[[], Result]], until: float = inf) -> Iterator[Done[Result]]:
        from distributed import as_completed
        from distributed.client import FutureCancelledError
        from distributed.scheduler import KilledWorker

        with self._client() as client:
            batch = token_hex(4)
            waiting = deque(range(len(tasks)))
            places: dict[Any, int] = {}
            completed = as_completed(loop=client.loop, raise_errors=False)
            while True:
                # Two tasks are sent ahead for each worker, so that none waits for the next.
                most = 2 * max(len(_workers(client)), 1)
                while waiting and len(places) < most and time.monotonic() < until:
                    place = waiting.popleft()
                    future = client.submit(tasks[place], key=f"wirewear-{batch}-{place}", pure=False)
                    places[future] = place
                    completed.add(future)
                if not places:
                    return
                future = next(completed)
                place = places.pop(future)
                try:
                    yield Done(place, future.result())
                except KilledWorker as problem:
                    yield Done(place, error=LostTaskError(f"every worker that took it was lost: {problem}."))
                except FutureCancelledError:
                    yield Done(place, error=EngineError(f"{self.words} was closed."))
                except Exception as error:  # noqa: BLE001 - whatever a task raises is handed over
                    yield Done(place, error=error)
                finally:
                    future.release()

    @contextmanager
    def held(self) -> Iterator[None]:
        if self._kept is not None:
            yield
            return
        with self._connected() as client:
            self._kept = client
            try:
                yield
            finally:
                self._kept = None

    @contextmanager
    def _client(self) -> Iterator[Client]:
        if self._kept is not None:
            yield self._kept
            return
        with self._connected() as client:
            yield client

    @contextmanager
    def _connected(self) -> Iterator[Client]:
        try:
            from distributed import Client
            from distributed.comm.addressing import get_address_host_port
        except ImportError:
            raise EngineError(
                "clusters are reached by Dask, which is not installed: pip install 'wirewear[cluster]'."
            ) from None
        try:
            # A client that is refused its address is not closed before long, and with a traceback.
            if not self.address.startswith("inproc"):
                get_address_host_port(self.address)
            client = Client(self.address, timeout=PATIENCE_s, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as problem:
            reason = next(iter(str(problem).splitlines()), type(problem).__name__)
            raise EngineError(f"no Dask scheduler answers at {self.address!r} ({reason}).") from None
        with client:
            self._require_fit(client)
            yield client

    def _require_fit(self, client: Client) -> None:
        try:
            client.wait_for_workers(1, timeout=PATIENCE_s)
        except TimeoutError:
            raise EngineError(f"{self.words} has no workers: start some by `dask worker {self.address}`.") from None
        threads = {worker["nthreads"] for worker in _workers(client).values()}
        if threads != {1}:
            raise EngineError(
                f"workers of {self.words} have {max(threads)} threads, where gmsh needs processes of their own: start "
                "them with --nthreads 1, and --nworkers for more of them."
            )
        programs = client.run(_program, on_error="return")
        others = [worker for worker, program in programs.items() if program != _program()]
        if others:
            raise EngineError(
                f"{len(others)} of {len(programs)} workers of {self.words} run another version of wirewear, or none "
                f"(first: {others[0]}): install this one there."
            )


def _workers(client: Client) -> dict[str, Any]:
    found: dict[str, Any] = client.scheduler_info(n_workers=-1)["workers"]
    return found


def _program() -> str:
    return code_hash()


def end_with_parent() -> None:
    """End this process as soon as its parent has ended; called once, as the initializer of a pool's processes.

    A task that went on would write into the same files as its own resumption.
    """
    parent = multiprocessing.parent_process()
    if parent is not None:
        Thread(target=_end_after, args=(parent.sentinel,), daemon=True).start()


def _end_after(sentinel: int) -> None:
    connection.wait([sentinel])
    sys.stderr.write("wirewear: the process that started this one is gone; its work stops here.\n")
    sys.stderr.flush()
    os._exit(1)
