"""What the machine has left, so that hopeless work is refused before it begins; processes that end with their own."""

import multiprocessing
import os
import re
import shutil
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import wait
from pathlib import Path
from threading import Thread, current_thread, main_thread

from wirewear.base.errors import WirewearError, counted

MOST_MEMORY_GB = "WIREWEAR_MOST_MEMORY_GB"  #: Gigabytes that may be used whatever is free; see `most_memory`.

#: A file's contents may take this many times its own bytes: other programs compress, but not to nothing. What takes
#: less than the second number does no harm.
MOST_EXPANSION, HARMLESS = 100, 100e6


def require_room(path: Path, need: float, kind: type[WirewearError]) -> None:
    """See that what a file states to hold, in bytes of memory, can be held and can be true.
    Raises WirewearError, of the given kind, if it cannot.
    """
    size, free = path.stat().st_size, free_memory()
    if need > max(HARMLESS, MOST_EXPANSION * size):
        raise kind(
            f"{path} of {size_text(size)} states contents of {size_text(need)}, {MOST_EXPANSION} times its size and "
            "more: it is damaged, or made to fill the memory."
        )
    if need > free:
        raise kind(f"{path} would take {size_text(need)} of memory, where {size_text(free)} are free.")


def free_memory() -> float:
    """Bytes of memory that may be used: as WIREWEAR_MOST_MEMORY_GB says, else what is free, also in a container.

    Infinity where the system does not report it.
    """
    with suppress(ValueError):
        chosen = float(os.environ.get(MOST_MEMORY_GB, ""))
        if chosen > 0.0:
            return 1e9 * chosen
    return min(_of_machine(), _of_container())


def free_disk(path: Path) -> float:
    """Bytes that are free where a file or folder is, or is to be made; infinity where the system does not report it."""
    while not path.exists() and path != path.parent:
        path = path.parent
    try:
        return float(shutil.disk_usage(path).free)
    except OSError:
        return float("inf")


def size_text(size: float) -> str:
    """``46 TB``: bytes for people, to two digits."""
    for unit in ("bytes", "kB", "MB", "GB", "TB"):
        if size < 999.5 or unit == "TB":
            break
        size /= 1e3
    rounded = float(f"{size:.2g}")
    return f"{counted(rounded) if rounded >= 1e4 else f'{rounded:.4g}'} {unit}"


def _of_machine() -> float:
    with suppress(OSError):
        found = re.search(r"MemAvailable:\s*(\d+) kB", Path("/proc/meminfo").read_text(encoding="ascii"))
        if found:
            return 1024.0 * int(found[1])
    return float("inf")


def _of_container() -> float:
    """What a control group (version 2) leaves."""
    group = Path("/sys/fs/cgroup")
    with suppress(OSError, ValueError):
        limit, used = (int((group / name).read_text(encoding="ascii")) for name in ("memory.max", "memory.current"))
        return float(max(limit - used, 0))
    return float("inf")


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """Raise TimeoutError in what is done within it after so many seconds at work; in the main thread only.

    Only time on a processor counts: a busy machine makes nothing late. Signals go to the main thread alone.
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
