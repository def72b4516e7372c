"""What is kept to be used again: its owner's alone, healed where damaged, done without where there is no place."""

import os
import subprocess
import sys
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from solvers import NotConvergedError
from tests import synthetic_results
from tests.diagnosis_cases import record
from tests.test_simulate import coarse
from wirewear import RunResult, Study, write_result
from wirewear.base import cache, identity
from wirewear.base.cache import cache_directory, keep_within
from wirewear.base.errors import KeptNothingWarning
from wirewear.base.quantity import counted
from wirewear.base.writing import write_text
from wirewear.diagnosis.model import nominal
from wirewear.diagnosis.model.nominal import limits_of, nominal_run, nominal_study
from wirewear.results import RESULT_FILE_NAME

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for the cache; warnings are given anew."""
    monkeypatch.setenv("WIREWEAR_CACHE", str(tmp_path / "cache"))
    cache.WARNED.clear()
    return tmp_path / "cache"


def test_the_folder_is_made_for_its_owner_alone(home: Path) -> None:
    assert cache_directory() == home
    assert home.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("mode", [0o777, 0o1777, 0o775])
def test_in_a_folder_that_others_can_write_to_it_is_one_of_its_own(home: Path, mode: int) -> None:
    home.mkdir()
    home.chmod(mode)
    own = home / f"user-{os.geteuid()}"
    assert cache_directory() == own
    assert own.stat().st_mode & 0o777 == 0o700


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


def test_where_there_is_no_folder_one_warning_says_so(home: Path) -> None:
    home.write_text("a file")
    with pytest.warns(KeptNothingWarning) as told:
        found = [cache_directory() for _ in range(2)]
    assert found == [None, None]
    (warning,) = told
    assert str(warning.message) == (
        f"{home} cannot be used (it is a file, not a folder): what is computed is not kept for the next time; "
        "WIREWEAR_CACHE names a folder."
    )


CLOSED = """
import sys
from pathlib import Path
from studies.benchmarks.forked_commands import _give_up_capabilities
from wirewear.base.cache import cache_directory

_give_up_capabilities()
print(cache_directory())
"""


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


@pytest.mark.parametrize("stated", ["", "relative"])
def test_a_cache_home_that_is_no_absolute_path_does_not_count(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, stated: str
) -> None:
    monkeypatch.delenv("WIREWEAR_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", stated)
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    assert cache_directory() == tmp_path / ".cache" / "wirewear"


def test_an_absolute_cache_home_counts_without_a_home(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("WIREWEAR_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.delattr(Path, "home")
    assert cache_directory() == tmp_path / "wirewear"


def test_runs_and_wires_share_one_size(tmp_path: Path) -> None:
    for age, name in enumerate(("nominal-a.h5", "wire-b.npz", "nominal-c.h5")):
        (tmp_path / name).write_bytes(bytes(100))
        os.utime(tmp_path / name, (1e9 + age, 1e9 + age))
    keep_within(tmp_path, 200.0)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["nominal-c.h5", "wire-b.npz"]


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


def test_a_nominal_run_is_kept_for_its_own_code_and_constants(
    runs: list[Study], monkeypatch: pytest.MonkeyPatch
) -> None:
    first, again = nominal_run(coarse()), nominal_run(coarse())
    assert len(runs) == 1
    np.testing.assert_array_equal(first.evolution["cycle"], again.evolution["cycle"])
    with monkeypatch.context() as changed:
        changed.setattr(identity, "code_hash", lambda _: "of other code")
        nominal_run(coarse())
    assert len(runs) == 2
    constants = dict(nominal._KNOWN.known)
    constants["late_loops"] = replace(constants["late_loops"], value=(0.5,))
    monkeypatch.setattr(nominal, "_KNOWN", replace(nominal._KNOWN, known=constants))
    nominal_run(coarse())
    assert len(runs) == 3


@pytest.mark.parametrize("damage", [b"", b"junk", None])
def test_a_damaged_nominal_run_is_made_anew_and_kept(runs: list[Study], home: Path, damage: bytes | None) -> None:
    nominal_run(coarse())
    (kept,) = home.glob("nominal-*.h5")
    whole = kept.read_bytes()
    kept.write_bytes(whole[:-300] + bytes([whole[-300] ^ 1]) + whole[-299:] if damage is None else damage)
    nominal_run(coarse())
    assert kept.read_bytes() == whole
    nominal_run(coarse())
    assert len(runs) == 2


def test_without_a_cache_the_run_is_made_each_time(runs: list[Study], home: Path) -> None:
    home.write_text("a file")
    with pytest.warns(KeptNothingWarning):
        nominal_run(coarse())
    nominal_run(coarse())
    assert len(runs) == 2


def test_a_full_disk_costs_the_next_time_only(runs: list[Study], home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> Path:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("wirewear.base.writing.write_bytes", full)
    with pytest.warns(KeptNothingWarning, match=r"\(no space left on device\)"):
        assert nominal_run(coarse()).status == "complete"
    assert not list(home.iterdir())


def test_of_runs_that_fail_the_one_that_comes_to_its_end_counts(
    runs: list[Study], monkeypatch: pytest.MonkeyPatch
) -> None:
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
    assert limits_of(found) == ()
    assert len(runs) == 2


def test_where_all_fail_the_farthest_says_how_far_it_came(runs: list[Study], monkeypatch: pytest.MonkeyPatch) -> None:
    made = synthetic_results.result(milestones=(1, 10, 100, 1000, 10000))

    def run_study(study: Study, *, output: Path, **_: object) -> list[RunResult]:
        runs.append(study)
        failed = replace(made, study=study.resolved(), status="failed", message="no solution.")
        write_result(output / RESULT_FILE_NAME, failed if len(runs) == 3 else replace(failed, loops=made.loops[:1]))
        raise NotConvergedError("no solution")

    monkeypatch.setattr("wirewear.simulation.run_study", run_study)
    for _ in range(2):
        (limits,) = limits_of(nominal_run(nominal_study(record(repeats=1, evolution=False))))
        assert limits == (
            f"the simulation of the nominal model ended at cycle {counted(made.loops[-1].cycle)} of 100\u2009000 "
            "(no solution): later wear is led on from there"
        )
    assert len(runs) == len(nominal._WEAR_MARGINS)


def test_no_warning_is_given_where_all_is_well() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert cache_directory() is not None


SIMULATING = """
from wirewear.base.engine import results_of
from wirewear.base.engine import LocalProcesses
from wirewear.base.errors import tell_plainly
from wirewear.base.cache import cache_directory

if __name__ == "__main__":
    tell_plainly()
    print(results_of(LocalProcesses(2, tasks_per_process=1), [cache_directory] * 3))
"""


def test_a_command_with_many_processes_warns_in_one_sentence(home: Path, tmp_path: Path) -> None:
    home.write_text("a file")
    script = write_text(tmp_path / "simulating.py", SIMULATING)
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    ended = subprocess.run([sys.executable, script], env=environment, capture_output=True, text=True, check=True)
    assert ended.stdout == "[None, None, None]\n"
    (line,) = ended.stderr.splitlines()
    assert line.startswith(f"wirewear: {home} cannot be used")
