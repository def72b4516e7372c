"""Ending work early: after a time limit, or when the parent process has ended."""

import multiprocessing
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.connection import wait
from threading import Thread, current_thread, main_thread


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """Raise TimeoutError in the enclosed work after this much processor time in s; does nothing outside the main
    thread.

    Only time on a processor counts, so that a busy machine makes nothing late. Signals go to the main thread only.
    """
    if current_thread() is not main_thread():
        yield
        return

    def late(_number: int, _frame: object) -> None:
        raise TimeoutError

    before = signal.signal(signal.SIGVTALRM, late)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)


def end_with_parent() -> None:
    """End this process as soon as its parent has ended; called once, as the initializer of a pool's processes.

    A task that went on would write into the same files as its own resumption.
    """
    parent = multiprocessing.parent_process()
    if parent is not None:
        Thread(target=_end_after, args=(parent.sentinel,), daemon=True).start()


def _end_after(sentinel: int) -> None:
    wait([sentinel])
    sys.stderr.write("wirewear: the process that started this one is gone; its work stops here.\n")
    sys.stderr.flush()
    os._exit(1)
