"""A program run in a process of its own, with its time and largest memory.

Memory is the high-water mark of the program's own image, VmHWM of /proc/PID/status: unlike ru_maxrss, it does not
start from what the parent held when it forked. Where /proc is missing, ru_maxrss has to do.
"""

import os
import re
import subprocess
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

_PAUSE_s = 0.1  #: Seconds between two looks at a process.


@dataclass(frozen=True)
class Usage:
    """Wall and CPU seconds of a running process since its start, and its largest memory so far."""

    wall_s: float
    cpu_s: float
    peak_memory_MB: float


@dataclass(frozen=True)
class ProcessCost:
    """How a process ended and what it took; stopped: it had not ended when its time was over."""

    status: int
    wall_s: float
    cpu_s: float
    peak_memory_MB: float
    stopped: bool = False


def run_measured(
    command: Sequence[str],
    folder: Path,
    log: Path,
    *,
    environment: Mapping[str, str] | None = None,
    most_s: float | None = None,
    watch: Callable[[Usage], None] | None = None,
) -> ProcessCost:
    """Run a command on one thread in a folder, with what it prints in a log.

    environment: variables set besides those of this process. most_s: wall seconds after which it is stopped. watch:
    called with what the process has used so far, some ten times a second while it runs (Linux only).
    """
    variables = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"} | dict(environment or {})
    start = time.perf_counter()
    last = Usage(0.0, 0.0, 0.0)
    stopped = False
    with log.open("wb") as output:
        process = subprocess.Popen(command, cwd=folder, env=variables, stdout=output, stderr=subprocess.STDOUT)
        try:
            while True:
                if (used := _usage(process.pid, time.perf_counter() - start)) is not None:
                    last = used
                    if watch is not None:
                        watch(used)
                ended, status, resources = os.wait4(process.pid, os.WNOHANG)
                if ended:
                    break
                if not stopped and most_s is not None and time.perf_counter() - start > most_s:
                    stopped = True
                    process.kill()
                time.sleep(_PAUSE_s)
        except BaseException:
            process.kill()
            raise
    process.returncode = os.waitstatus_to_exitcode(status)
    return ProcessCost(
        process.returncode,
        time.perf_counter() - start,
        resources.ru_utime + resources.ru_stime,
        last.peak_memory_MB or resources.ru_maxrss / 1024.0,
        stopped,
    )


def _usage(pid: int, wall_s: float) -> Usage | None:
    """None for a process that has just ended, and without /proc."""
    try:
        status = Path(f"/proc/{pid}/status").read_text(encoding="ascii", errors="replace")
        # The second field of stat is the program's name in brackets, which may hold blanks.
        fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii", errors="replace").rpartition(")")[2].split()
    except OSError:
        return None
    peak = re.search(r"^VmHWM:\s+(\d+) kB", status, re.MULTILINE)
    if peak is None:
        return None
    ticks = int(fields[11]) + int(fields[12])
    return Usage(wall_s, ticks / os.sysconf("SC_CLK_TCK"), int(peak[1]) / 1024.0)
