"""Tasks of a batch in processes of their own."""

import operator
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest

from wirewear.blind.workers import finished_tasks

BEATING = """
import time
from pathlib import Path
for beat in range(600):
    Path({path!r}).write_text(str(beat))
    time.sleep(0.05)
"""

STARTING = """
from functools import partial
from wirewear.blind.workers import finished_tasks
list(finished_tasks([partial(exec, {beating!r})], 1))
"""


@pytest.mark.slow
def test_every_task_is_done_once_until_one_fails() -> None:
    tasks = [partial(operator.truediv, 1.0, number) for number in (1.0, 2.0, 0.0)]
    done: list[int] = []
    with pytest.raises(ZeroDivisionError):
        done.extend(finished_tasks(tasks, 1))
    assert done == [0, 1]


def test_no_task_is_begun_when_the_time_is_up() -> None:
    assert list(finished_tasks([partial(operator.index, 1)], 1, until=time.monotonic() - 1.0)) == []  # type: ignore[list-item]


@pytest.mark.slow
def test_a_task_ends_with_the_process_that_started_it_even_when_that_is_killed(tmp_path: Path) -> None:
    heart = tmp_path / "heart"
    script = STARTING.format(beating=BEATING.format(path=str(heart)))
    starting = subprocess.Popen([sys.executable, "-c", script], stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 60.0
    while not heart.exists():
        assert time.monotonic() < deadline
        time.sleep(0.05)
    starting.kill()
    starting.wait()
    time.sleep(0.5)
    last = heart.read_text()
    time.sleep(0.5)
    assert heart.read_text() == last
