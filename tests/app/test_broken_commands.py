"""Killed workers, full disks at checkpoints, other folders, locales and threads, interruptions; no code from data."""

import ast
import os
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import Result

from tests.robustness.commands import STUDY
from tests.simulation.coarse_runs import coarse
from wirewear import ResultError, read_result, run_study
from wirewear.simulation import Observer

ROOT = Path(__file__).parents[2]
# In a process of its own, so that what dies with it takes no other test along.
KILLED = """
from tests.app.test_broken_commands import Silent, killed, killed_maker
from wirewear.base.engine import results_of
from wirewear.base.engine import LocalProcesses
from wirewear.base.errors import WirewearError
from wirewear.simulation.runs import run_side_by_side
engine = LocalProcesses(1)
for begin in (lambda: run_side_by_side([killed], [Silent()], engine), lambda: results_of(engine, [killed_maker])):
    try:
        begin()
    except WirewearError as error:
        print(type(error).__name__, error)
"""


def sentence_of(ended: Result) -> str:
    assert ended.exit_code == 2, ended.output
    assert "Traceback" not in ended.output
    (sentence,) = ended.stderr.strip().splitlines()[-1:]
    assert sentence.startswith("wirewear: ")
    return sentence


def killed(_observer: Observer) -> str:
    os.kill(os.getpid(), signal.SIGKILL)
    return "never"


def killed_maker() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


class Silent:
    """Watches nothing."""

    def __getattr__(self, _name: str) -> Any:
        return lambda *_: None


@pytest.mark.slow
def test_a_killed_worker_is_stated_in_one_sentence() -> None:
    ended = subprocess.run([sys.executable, "-c", KILLED], cwd=ROOT, capture_output=True, text=True, check=False)
    run, batch = ended.stdout.splitlines()
    ended_outside = "was ended from outside, perhaps because memory ran out"
    assert run.startswith("RunError ")
    assert f"{ended_outside}: --resume goes on" in run
    assert batch.startswith("LostTaskError ")
    assert f"{ended_outside}: the same command" in batch


@pytest.mark.slow
def test_a_full_disk_at_a_checkpoint_says_how_to_go_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Version 8318817 ended with a segmentation fault."""

    def full(*_: object) -> Path:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("wirewear.simulation.store.write_bytes", full)
    with pytest.raises(ResultError) as refused:
        run_study(coarse(), fidelity="quick", output=tmp_path)
    assert str(refused.value) == (
        f"cannot write the checkpoint {tmp_path / 'checkpoint.h5'}: no space left on device; --resume goes on once it "
        "can be written."
    )
    assert read_result(tmp_path).status == "running"


RUN = ("run", "study.toml", "--fidelity", "quick", "--output")
#: Three cycles of it.
BRIEF = STUDY.replace("\ncycles = 30\n", "\ncycles = 3\n").replace("[1, 3, 10, 30]", "[1, 3]")


def run(folder: Path, output: str, variables: Mapping[str, str]) -> Path:
    """The result of the command, as users give it, on the study in a folder."""
    folder.mkdir()
    (folder / "study.toml").write_text(BRIEF)
    ended = subprocess.run(
        [sys.executable, "-c", "from wirewear.app.cli import main; main()", *RUN, output], cwd=folder,
        capture_output=True, text=True, check=False, timeout=1200, env={**os.environ, **variables},
    )  # fmt: skip
    assert ended.returncode == 0, ended.stderr
    return folder / output / "result.h5"


@pytest.mark.slow
def test_the_same_numbers_come_out_in_another_folder_and_locale_and_with_two_threads(tmp_path: Path) -> None:
    one = read_result(run(tmp_path / "first", "o", {})).evolution
    elsewhere = {"LC_ALL": "C", "PYTHONHASHSEED": "7", "TZ": "Asia/Tokyo"}
    threads = {"OMP_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "2"}
    for variables, to in ((elsewhere, 0.0), (threads, 1e-12)):
        other = read_result(run(tmp_path / f"within_{to}", str(to), variables)).evolution
        for name in one:
            np.testing.assert_allclose(other[name], one[name], rtol=to, err_msg=name)


@pytest.mark.slow
def test_no_code_comes_from_data() -> None:
    found = []
    for package in ("geometry", "solvers", "wirewear"):
        # Machine code that the program itself compiled is kept as numba keeps it, in folders of the user's own.
        for file in {*(ROOT / package).rglob("*.py")} - {ROOT / "solvers" / "jit_cache.py"}:
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                names = {alias.name for alias in node.names} if isinstance(node, ast.Import) else set()
                names |= {str(node.module)} if isinstance(node, ast.ImportFrom) else set()
                names |= {node.func.id} if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else set()
                names |= {str(node.arg)} if isinstance(node, ast.keyword) else set()
                found += [
                    f"{file}: {name}"
                    for name in names & {"pickle", "marshal", "shelve", "eval", "exec", "allow_pickle"}
                ]
    assert found == []


@pytest.mark.parametrize(
    ("loading", "how", "said"),
    [
        pytest.param("wirewear.app.cli.group", "SIGINT", "nothing was written", marks=pytest.mark.slow),
        pytest.param("wirewear.effects", "SIGHUP", "no file is left half written", marks=pytest.mark.slow),
        ("wirewear.effects", "SIGTERM", "no file is left half written"),
    ],
)
def test_a_signal_that_ends_a_program_or_command_is_one_sentence(loading: str, how: str, said: str) -> None:
    code = f"""
import os, signal, sys

class Interrupting:
    def find_spec(self, name, *_):
        if name == "{loading}":
            os.kill(os.getpid(), signal.{how})

sys.meta_path.insert(0, Interrupting())
from wirewear.app.cli import main
main()
"""
    ended = subprocess.run([sys.executable, "-c", code, "effects"], capture_output=True, text=True, check=False)
    assert ended.returncode == 130
    assert ended.stderr == f"wirewear: interrupted; {said}.\n"
