"""Time and memory of a process."""

import signal
import sys
from pathlib import Path

import numpy as np
import pytest

from studies.benchmarks.measured_process import ProcessCost, Usage, run_measured


def test_a_process_is_measured(tmp_path: Path) -> None:
    cost = run_measured(["sh", "-c", "exit 3"], tmp_path, tmp_path / "log")
    assert cost.status == 3
    assert not cost.stopped
    assert cost.peak_memory_MB > 0.0


WAITING = """
import os, time
{work}
open("worked", "w").close()
while not os.path.exists("looked at"):
    time.sleep(0.01)
"""


def looked_at(folder: Path, work: str) -> ProcessCost:
    """What a program takes that does some work and ends when it has been looked at since."""
    folder.mkdir()
    worked = False

    def watch(_: Usage) -> None:
        nonlocal worked
        if worked:
            (folder / "looked at").touch()
        worked = (folder / "worked").exists()

    return run_measured([sys.executable, "-S", "-c", WAITING.format(work=work)], folder, folder / "log", watch=watch)


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory of a running process is read from /proc")
def test_memory_is_that_of_the_program_itself_and_not_of_its_parent(tmp_path: Path) -> None:
    ballast = np.ones(2**25)
    small = looked_at(tmp_path / "small", "pass")
    assert small.peak_memory_MB < 20.0 < ballast.nbytes / 2**20
    large = looked_at(tmp_path / "large", "b = bytearray(b'x') * 10**8; del b")
    assert 95.0 < large.peak_memory_MB < 140.0


def test_a_process_is_stopped_when_its_time_is_over(tmp_path: Path) -> None:
    seen = list[Usage]()
    cost = run_measured(["sleep", "3600"], tmp_path, tmp_path / "log", most_s=0.3, watch=seen.append)
    assert cost.stopped
    assert cost.status == -signal.SIGKILL
    assert 0.3 < cost.wall_s < 3600.0
    assert seen


def test_the_environment_of_a_process_can_be_set(tmp_path: Path) -> None:
    run_measured(["sh", "-c", "echo $BALLAST"], tmp_path, tmp_path / "log", environment={"BALLAST": "lead"})
    assert (tmp_path / "log").read_text() == "lead\n"
