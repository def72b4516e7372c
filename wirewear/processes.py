"""Processes that end with the one that started them, even when that is killed."""

from __future__ import annotations

import multiprocessing
import os
import sys
from multiprocessing.connection import wait
from threading import Thread


def end_with_parent() -> None:
    """End this process as soon as its parent is gone; to be called once, as the initializer of a pool's processes.

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
