"""Engines: every task once, lost processes replaced, local processes and a Dask cluster alike."""

import operator
import os
import signal
import subprocess
import sys
import time
import warnings
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest

from wirewear.base.engine import Engine, engine_of, results_of

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def cluster() -> Iterator[str]:
    """The address of a Dask cluster of two workers on this machine."""
    from distributed import LocalCluster

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50) as cluster:
            yield cluster.scheduler_address


@pytest.fixture(autouse=True)
def _patience(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a busy machine answers may take long to come."""
    monkeypatch.setattr("wirewear.base.engine.PATIENCE_s", 600.0)


@pytest.fixture(params=["processes", pytest.param("cluster", marks=pytest.mark.slow)])
def engine(request: pytest.FixtureRequest) -> Engine:
    return engine_of(2, request.getfixturevalue("cluster") if request.param == "cluster" else None)


def killed_the_first_time(folder: Path, number: int) -> int:
    """The number; of number 3 the process is killed the first time."""
    begun = folder / f"{number}-{time.monotonic_ns()}"
    begun.touch()
    if number == 3 and len(list(folder.glob("3-*"))) == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def killed() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.slow
def test_every_task_is_handed_over_once_with_what_it_returned_or_raised(engine: Engine) -> None:
    tasks = [partial(operator.truediv, 6.0, number) for number in (1.0, 2.0, 0.0, 3.0)]
    done = sorted(engine.done(tasks), key=lambda one: one.place)
    assert [one.place for one in done] == [0, 1, 2, 3]
    assert [one.result for one in done] == [6.0, 3.0, None, 2.0]
    with pytest.raises(ZeroDivisionError):
        results_of(engine, tasks)


# In a process of its own, so that what dies with it takes no other test along.
LOSING = """
import operator, sys
from functools import partial
from pathlib import Path
from tests.test_engine import killed, killed_the_first_time
from wirewear.base import engine as engines
from wirewear.base.engine import engine_of

engines.PATIENCE_s = 600.0
folder, address = Path(sys.argv[1]), sys.argv[2] or None
engine = engine_of(2, address)
tasks = [partial(killed_the_first_time, folder, number) for number in range(8)]
print(sorted(one.value() for one in engine.done(tasks)))
if address is None:
    done = {one.place: one for one in engine.done([killed, partial(operator.index, 1)])}
    print(type(done[0].error).__name__, done[1].value())
"""


def lost(folder: Path, address: str) -> list[str]:
    command = [sys.executable, "-c", LOSING, str(folder), address]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()


@pytest.mark.slow
def test_a_process_that_is_lost_is_replaced_and_no_result_comes_twice(tmp_path: Path) -> None:
    """A task whose process is lost every time takes no other along."""
    assert lost(tmp_path, "") == [str(list(range(8))), "LostTaskError 1"]
    assert len(list(tmp_path.glob("3-*"))) == 2
