"""Processes end with the one that started them."""

import subprocess
import sys
import time
from pathlib import Path

import pytest

BEATING = """
import time
from pathlib import Path

def beat(_observer=None):
    for number in range(6000):
        Path("heart").write_text(str(number))
        time.sleep(0.05)
"""

STARTING = {
    "records of a batch": ("from wirewear.base.engine import LocalProcesses; list(LocalProcesses(1).done([beat]))"),
    "variants of a study": (
        "from wirewear.simulation.together import run_side_by_side; "
        "from wirewear.base.engine import LocalProcesses; "
        "run_side_by_side([beat], [None], LocalProcesses(1))"
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("what", STARTING)
def test_a_task_ends_with_the_process_that_started_it_even_when_that_is_killed(what: str, tmp_path: Path) -> None:
    (tmp_path / "beating.py").write_text(BEATING)
    script = f"import sys; sys.path.insert(0, '.'); from beating import beat; {STARTING[what]}"
    starting = subprocess.Popen(
        [sys.executable, "-c", script], cwd=tmp_path, stderr=subprocess.PIPE, text=True, encoding="utf-8"
    )
    heart = tmp_path / "heart"
    while not heart.exists():
        assert starting.poll() is None
        time.sleep(0.05)
    starting.kill()
    # Its errors are at an end when no process holds them any more: neither it nor the task, which would go on for long.
    said = starting.communicate()[1]
    assert "the process that started this one is gone" in said
    last = heart.read_text()
    time.sleep(0.5)
    assert heart.read_text() == last
