"""Runs of several variants side by side, each in a process of its own, watched from here."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing.managers import SyncManager
from queue import Empty
from typing import Any, Protocol, TypeVar

from wirewear.errors import RunError
from wirewear.processes import end_with_parent
from wirewear.results import RunResult
from wirewear.simulation.observers import Moment, RunObserver

_POLL_s = 0.1

LOST_PROCESS = (
    "a process that simulated was ended from outside, perhaps because memory ran out: --resume goes on, with fewer "
    "--jobs in less memory."
)

Result = TypeVar("Result")


class Mailbox(Protocol):
    """The part of a queue between processes that is used here."""

    def put(self, item: Any) -> None:
        """Send an item."""

    def get(self, block: bool = True, timeout: float | None = None) -> Any:
        """Receive an item, or raise queue.Empty after the timeout."""


@dataclass(frozen=True)
class RemoteObserver:
    """Sends what a run tells it to the process that watches."""

    index: int
    mailbox: Mailbox

    def stage(self, text: str) -> None:
        """Pass on that a part of the preparation begins."""
        self._send("stage", text)

    def moved(self, moment: Moment) -> None:
        """Pass on that an increment is done."""
        self._send("moved", moment)

    def logged(self, result: RunResult) -> None:
        """Pass on what is on disk."""
        self._send("logged", result)

    def note(self, sentence: str) -> None:
        """Pass on what the user should know."""
        self._send("note", sentence)

    def _send(self, kind: str, item: object) -> None:
        self.mailbox.put((self.index, kind, item))


def run_side_by_side(
    tasks: Sequence[Callable[[RunObserver], Result]], observers: Sequence[RunObserver], jobs: int
) -> list[Result]:
    """Do tasks in up to `jobs` processes; each is called with an observer that reports to its own of `observers`.

    When a task fails, the others still come to their end; then the first error is raised.
    """
    context = multiprocessing.get_context("spawn")
    manager = SyncManager(ctx=context)
    manager.start(end_with_parent)
    with manager, ProcessPoolExecutor(jobs, mp_context=context, initializer=end_with_parent) as pool:
        mailbox = manager.Queue()
        futures = [pool.submit(task, RemoteObserver(index, mailbox)) for index, task in enumerate(tasks)]
        while not all(future.done() for future in futures):
            _deliver(mailbox, observers)
        _deliver(mailbox, observers)
        return _results(futures)


def _deliver(mailbox: Mailbox, observers: Sequence[RunObserver]) -> None:
    try:
        while True:
            index, kind, item = mailbox.get(timeout=_POLL_s)
            getattr(observers[index], kind)(item)
    except Empty:
        return


def _results(futures: Sequence[Future[Result]]) -> list[Result]:
    for future in futures:
        error = future.exception()
        if isinstance(error, BrokenProcessPool):
            raise RunError(LOST_PROCESS) from error
        if error is not None:
            raise error
    return [future.result() for future in futures]
