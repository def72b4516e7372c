"""Time and memory of a process."""

import sys
from pathlib import Path

import numpy as np
import pytest

from studies.benchmarks.measured_process import Usage, run_measured


def test_a_process_is_measured(tmp_path: Path) -> None:
    cost = run_measured(["sh", "-c", "exit 3"], tmp_path, tmp_path / "log")
    assert cost.status == 3
    assert not cost.stopped
    assert cost.peak_memory_MB > 0.0


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory of a running process is read from /proc")
def test_memory_is_that_of_the_program_itself_and_not_of_its_parent(tmp_path: Path) -> None:
    ballast = np.ones(2**25)
    small = run_measured(["sleep", "0.3"], tmp_path, tmp_path / "log")
    assert small.peak_memory_MB < 20.0 < ballast.nbytes / 2**20
    program = "import time; b = bytearray(b'x') * 10**8; time.sleep(0.3); del b; time.sleep(0.3)"
    large = run_measured([sys.executable, "-S", "-c", program], tmp_path, tmp_path / "log")
    assert 95.0 < large.peak_memory_MB < 140.0


def test_a_process_is_stopped_when_its_time_is_over(tmp_path: Path) -> None:
    seen = list[Usage]()
    cost = run_measured(["sleep", "60"], tmp_path, tmp_path / "log", most_s=0.3, watch=seen.append)
    assert cost.stopped
    assert cost.wall_s < 10.0
    assert len(seen) > 1


def test_the_environment_of_a_process_can_be_set(tmp_path: Path) -> None:
    run_measured(["sh", "-c", "echo $BALLAST"], tmp_path, tmp_path / "log", environment={"BALLAST": "lead"})
    assert (tmp_path / "log").read_text() == "lead\n"
