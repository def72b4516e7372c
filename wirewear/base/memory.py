"""Free memory and disk space, so that work too large for them is refused before it starts."""

import os
import re
import shutil
from contextlib import suppress
from pathlib import Path

from wirewear.base.errors import WirewearError
from wirewear.base.words import counted

MOST_MEMORY_GB = "WIREWEAR_MOST_MEMORY_GB"  #: Gigabytes that may be used whatever is free; see `most_memory`.

#: A file's contents may take this many times its own bytes: other programs compress, but not to nothing. What takes
#: less than the second number does no harm.
MOST_EXPANSION, HARMLESS = 100, 100e6


def require_room(path: Path, need: float, kind: type[WirewearError]) -> None:
    """Check that contents of `need` bytes, as a file states them, fit into free memory and are at most a hundred times
    the file's size (small ones pass).

    Raises an error of class `kind` if not.
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
    """Usable memory in bytes: WIREWEAR_MOST_MEMORY_GB if set, else what is free, within the limits of a container.

    Infinity if the system does not report it.
    """
    with suppress(ValueError):
        chosen = float(os.environ.get(MOST_MEMORY_GB, ""))
        if chosen > 0.0:
            return 1e9 * chosen
    return min(_of_machine(), _of_container())


def free_disk(path: Path) -> float:
    """Free bytes on the disk of a path, which need not exist yet; infinity if the system does not report it."""
    while not path.exists() and path != path.parent:
        path = path.parent
    try:
        return float(shutil.disk_usage(path).free)
    except OSError:
        return float("inf")


def size_text(size: float) -> str:
    """A size in bytes as text with two digits, such as ``46 TB``."""
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
    """Free memory in bytes within the control group (version 2) of a container; infinity outside one."""
    group = Path("/sys/fs/cgroup")
    with suppress(OSError, ValueError):
        limit, used = (int((group / name).read_text(encoding="ascii")) for name in ("memory.max", "memory.current"))
        return float(max(limit - used, 0))
    return float("inf")
