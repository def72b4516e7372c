"""What is kept to be used again: its owner's alone, within bounds, healed where damaged, done without otherwise."""

import multiprocessing
import operator
import os
import signal
import subprocess
import sys
import time
import warnings
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from threading import Thread

import numpy as np
import pytest

from solvers import NotConvergedError
from tests import synthetic_results
from tests.simulation.coarse_runs import coarse
from wirewear import RunResult, Study, write_result
from wirewear.base import cache
from wirewear.base.cache import cache_directory, keep_within, mark_used
from wirewear.base.engine import Engine, engine_of, results_of
from wirewear.base.errors import KeptNothingWarning
from wirewear.diagnosis.surrogate import nominal
from wirewear.diagnosis.surrogate.nominal import limits_of, nominal_run
from wirewear.results import RESULT_FILE_NAME

ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for the cache; warnings are given again."""
    monkeypatch.setenv("WIREWEAR_CACHE", str(tmp_path / "cache"))
    cache.WARNED.clear()
    return tmp_path / "cache"


def test_the_folder_is_made_for_its_owner_alone(home: Path) -> None:
    assert cache_directory() == home
    assert home.stat().st_mode & 0o777 == 0o700


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give a folder away")
def test_in_anothers_folder_it_is_one_of_its_own_and_anothers_there_is_not_trusted(home: Path) -> None:
    home.mkdir()
    os.chown(home, 12345, 12345)
    own = cache_directory()
    assert own == home / "user-0"
    os.chown(own, 12345, 12345)
    with pytest.warns(KeptNothingWarning, match="can be written to by others"):
        assert cache_directory() is None


def test_a_link_in_a_shared_folder_is_not_followed(home: Path, tmp_path: Path) -> None:
    home.mkdir()
    home.chmod(0o777)
    (tmp_path / "elsewhere").mkdir()
    (home / f"user-{os.geteuid()}").symlink_to(tmp_path / "elsewhere")
    with pytest.warns(KeptNothingWarning):
        assert cache_directory() is None


CLOSED = """
import sys
from pathlib import Path
from threading import Timer
from tests.robustness.forked import give_up_capabilities
from wirewear.base.cache import cache_directory

give_up_capabilities()
print(cache_directory())
"""


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize("mode", [0o500, 0o600, 0o000])
def test_where_the_folder_cannot_be_written_or_entered_one_warning_says_so(home: Path, mode: int) -> None:
    home.mkdir(mode=mode)
    ended = subprocess.run([sys.executable, "-c", CLOSED], cwd=ROOT, capture_output=True, text=True, check=True)
    assert ended.stdout == "None\n"
    assert ended.stderr.count("KeptNothingWarning: ") == 1
    assert "can be neither read nor written" in ended.stderr


def test_without_home_and_name_there_is_no_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    def unknown() -> Path:
        raise RuntimeError("Could not determine home directory.")

    for name in ("WIREWEAR_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", unknown)
    with pytest.warns(KeptNothingWarning, match="the cache folder cannot be used"):
        assert cache_directory() is None


# The nominal run


@pytest.fixture
def runs(monkeypatch: pytest.MonkeyPatch) -> list[Study]:
    """The studies that were simulated; each leaves figures made up instead."""
    asked: list[Study] = []

    def run_study(study: Study, *, output: Path, **_: object) -> list[RunResult]:
        asked.append(study)
        write_result(output / RESULT_FILE_NAME, synthetic_results.result())
        return [replace(synthetic_results.result(), path=output / RESULT_FILE_NAME)]

    monkeypatch.setattr("wirewear.simulation.run_study", run_study)
    return asked


def test_a_nominal_run_is_kept_for_its_code_and_constants(runs: list[Study], monkeypatch: pytest.MonkeyPatch) -> None:
    first, again = nominal_run(coarse()), nominal_run(coarse())
    assert len(runs) == 1
    np.testing.assert_array_equal(first.evolution["cycle"], again.evolution["cycle"])
    with monkeypatch.context() as changed:
        changed.setattr(cache, "code_hash", lambda _: "of other code")
        nominal_run(coarse())
    assert len(runs) == 2
    constants = dict(nominal._KNOWN.known)
    constants["late_loops"] = replace(constants["late_loops"], value=(0.5,))
    monkeypatch.setattr(nominal, "_KNOWN", replace(nominal._KNOWN, known=constants))
    nominal_run(coarse())
    assert len(runs) == 3


@pytest.mark.parametrize("damage", [b"", b"junk", None])
def test_a_damaged_nominal_run_is_made_again_and_kept(runs: list[Study], home: Path, damage: bytes | None) -> None:
    nominal_run(coarse())
    (kept,) = home.glob("nominal-*.h5")
    whole = kept.read_bytes()
    kept.write_bytes(whole[:-300] + bytes([whole[-300] ^ 1]) + whole[-299:] if damage is None else damage)
    nominal_run(coarse())
    assert kept.read_bytes() == whole
    nominal_run(coarse())
    assert len(runs) == 2


def test_of_runs_that_fail_the_one_that_ends_counts(runs: list[Study], monkeypatch: pytest.MonkeyPatch) -> None:
    complete = synthetic_results.result()

    def run_study(study: Study, *, output: Path, **_: object) -> list[RunResult]:
        runs.append(study)
        if len(runs) == 1:
            write_result(output / RESULT_FILE_NAME, replace(complete, status="failed", message="no solution"))
            raise NotConvergedError("no solution")
        write_result(output / RESULT_FILE_NAME, complete)
        return [replace(complete, path=output / RESULT_FILE_NAME)]

    monkeypatch.setattr("wirewear.simulation.run_study", run_study)
    found = nominal_run(coarse())
    assert found.status == "complete"
    assert limits_of(found, coarse()) == ()
    assert len(runs) == 2


@pytest.fixture
def wires(tmp_path: Path) -> list[Path]:
    """Four wires of 100 bytes, the first one unused for longest."""
    paths = [tmp_path / f"wire-{name}.npz" for name in "dcba"]
    for age, path in enumerate(paths):
        path.write_bytes(bytes(100))
        os.utime(path, (1e9 + age, 1e9 + age))
    return paths


def test_wires_unused_for_longest_go_first_and_one_that_is_used_stays(wires: list[Path]) -> None:
    mark_used(wires[0])
    keep_within(wires[0].parent, 350.0)
    assert [path.exists() for path in wires] == [True, False, True, True]
    keep_within(wires[0].parent, 200.0)
    assert [path.exists() for path in wires] == [True, False, False, True]


def test_other_files_stay_and_abandoned_parts_of_wires_go(tmp_path: Path) -> None:
    mine, left = tmp_path / "notes.txt", tmp_path / ".wire-a.npz.1.partial"
    fresh = tmp_path / ".wire-b.npz.2.partial"
    for path in (mine, left, fresh):
        path.write_bytes(bytes(100))
    os.utime(left, (1e9, 1e9))
    keep_within(tmp_path, 0.0)
    assert [path.exists() for path in (mine, left, fresh)] == [True, False, True]


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
    (folder / f"{number}-{time.monotonic_ns()}").touch()
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


@pytest.mark.seconds
def test_an_interruption_waits_for_no_task_of_this_machine() -> None:
    before = set(multiprocessing.active_children())

    def interrupt_once_it_runs() -> None:
        while set(multiprocessing.active_children()) <= before:
            time.sleep(0.1)
        time.sleep(0.5)
        os.kill(os.getpid(), signal.SIGINT)

    Thread(target=interrupt_once_it_runs, daemon=True).start()
    began = time.monotonic()
    # What a shell starts in the background ignores interruptions.
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            list(engine_of(1).done([partial(time.sleep, 20.0)]))
    finally:
        signal.signal(signal.SIGINT, handler)
    assert time.monotonic() - began < 15.0


# In a process of its own, so that what dies with it takes no other test along.
LOSING = """
import operator, sys
from functools import partial
from pathlib import Path
from threading import Timer
from tests.base.test_cache import killed, killed_the_first_time
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
