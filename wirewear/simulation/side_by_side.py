"""Runs of several variants side by side, each in a process of its own, watched from here."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from multiprocessing.managers import SyncManager
from queue import Empty
from threading import Event
from typing import Any, Protocol, TypeVar

from wirewear.engine import Done, Engine, LocalProcesses, results_of
from wirewear.errors import LostTaskError, RunError
from wirewear.processes import end_with_parent
from wirewear.simulation.observers import Moment, NoObserver, Observer

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

    def logged(self, result: object) -> None:
        """Pass on what is on disk."""
        self._send("logged", result)

    def note(self, sentence: str) -> None:
        """Pass on what the user should know."""
        self._send("note", sentence)

    def _send(self, kind: str, item: object) -> None:
        self.mailbox.put((self.index, kind, item))


def run_side_by_side(
    tasks: Sequence[Callable[[Observer[Any]], Result]], observers: Sequence[Observer[Any]], engine: Engine
) -> list[Result]:
    """Do tasks side by side; each is called with an observer that reports to its own of `observers`.

    Workers of a cluster report nothing: they may be anywhere. When a task fails, the others still come to their end;
    then the first error is raised.
    """
    if not isinstance(engine, LocalProcesses):
        return results_of(engine, [partial(task, NoObserver()) for task in tasks])
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


def _done_until(stop: Event, engine: Engine, tasks: Sequence[Callable[[], Result]]) -> list[Done[Result]]:
    """All tasks in their order, or those that were done when it was to stop."""
    every = []
    for one in engine.done(tasks):
        every.append(one)
        if stop.is_set():
            break
    return sorted(every, key=lambda one: one.place)


def _deliver(mailbox: Mailbox, observers: Sequence[Observer[Any]]) -> None:
    try:
        while True:
            index, kind, item = mailbox.get(timeout=_POLL_s)
            getattr(observers[index], kind)(item)
    except Empty:
        return
