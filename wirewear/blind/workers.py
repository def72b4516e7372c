"""Tasks in processes of their own that end with the process that started them."""

from __future__ import annotations

import multiprocessing
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool

from wirewear.errors import BlindError
from wirewear.processes import end_with_parent

LOST_PROCESS = (
    "a process at work was ended from outside, perhaps because memory ran out: the same command goes on, with fewer "
    "--jobs in less memory."
)

#: New processes now and then: what libraries keep of one task does not add up over a night.
TASKS_PER_PROCESS = 20


def finished_tasks(tasks: Sequence[Callable[[], None]], jobs: int, until: float = float("inf")) -> Iterator[int]:
    """Do tasks in up to `jobs` processes, none begun after `until` (of time.monotonic); yields places as they finish.

    When one fails, those that run come to their end, and its error is raised.
    """
    remaining = deque(enumerate(tasks))
    # Threads of the parent's libraries do not survive a fork.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(
        jobs, mp_context=context, initializer=end_with_parent, max_tasks_per_child=TASKS_PER_PROCESS
    ) as pool:
        running: dict[Future[None], int] = {}
        while remaining or running:
            while remaining and len(running) < jobs and time.monotonic() < until:
                place, task = remaining.popleft()
                running[pool.submit(task)] = place
            if not running:
                return
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                try:
                    future.result()
                except BrokenProcessPool as error:
                    raise BlindError(LOST_PROCESS) from error
                yield running.pop(future)
