"""A program run in a process of its own, with its time and largest memory."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class ProcessCost:
    """How a process ended and what it took."""

    status: int
    wall_s: float
    cpu_s: float
    peak_memory_MB: float


def run_measured(command: Sequence[str], folder: Path, log: Path) -> ProcessCost:
    """Run a command on one thread in a folder, with what it prints in a log."""
    environment = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    start = time.perf_counter()
    with log.open("wb") as output:
        process = subprocess.Popen(command, cwd=folder, env=environment, stdout=output, stderr=subprocess.STDOUT)
        _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    wall = time.perf_counter() - start
    return ProcessCost(process.returncode, wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024.0)
