"""Full disks, lost permissions, killed processes, interruptions: one sentence each, never a traceback."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from tests.diagnosis_cases import diagnosed, record
from tests.synthetic_results import result
from tests.test_simulate import coarse
from wirewear import (
    ResultError,
    read_result,
    run_study,
    write_result,
)
from wirewear.diagnosis import write_diagnosis
from wirewear.faces import cli
from wirewear.simulation import Observer

ROOT = Path(__file__).resolve().parent.parent


def told(ended: Result) -> str:
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


# In a process of its own, so that what dies with it takes no other test along.
KILLED = """
from tests.test_hardships import Silent, killed, killed_maker
from wirewear.base.engine import results_of
from wirewear.base.local_processes import LocalProcesses
from wirewear.base.errors import WirewearError
from wirewear.simulation.together import run_side_by_side
engine = LocalProcesses(1)
for begin in (lambda: run_side_by_side([killed], [Silent()], engine), lambda: results_of(engine, [killed_maker])):
    try:
        begin()
    except WirewearError as error:
        print(type(error).__name__, error)
"""


@pytest.mark.slow
def test_a_killed_worker_is_told_in_one_sentence() -> None:
    ended = subprocess.run([sys.executable, "-c", KILLED], cwd=ROOT, capture_output=True, text=True, check=False)
    run, batch = ended.stdout.splitlines()
    ended_outside = "was ended from outside, perhaps because memory ran out"
    assert run.startswith("RunError ")
    assert f"{ended_outside}: --resume goes on" in run
    assert batch.startswith("LostTaskError ")
    assert f"{ended_outside}: the same command" in batch


@pytest.mark.slow
def test_a_full_disk_at_the_end_of_a_diagnosis_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> Path:
        raise OSError(28, "No space left on device")

    found = diagnosed(record(repeats=1, evolution=False, normal=False))
    monkeypatch.setattr("wirewear.views.diagnosis_page.write_text", full)
    with pytest.raises(ResultError, match=r"^cannot write the diagnosis to .*: no space left on device\.$"):
        write_diagnosis(found, tmp_path / "out")


@pytest.mark.slow
def test_a_full_disk_at_a_checkpoint_says_how_to_go_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Version 8318817 ended with a segmentation fault."""

    def full(*_: object) -> Path:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("wirewear.simulation.checkpoint.write_bytes", full)
    with pytest.raises(ResultError) as refused:
        run_study(coarse(), fidelity="quick", output=tmp_path)
    assert str(refused.value) == (
        f"cannot write the checkpoint {tmp_path / 'checkpoint.h5'}: no space left on device; --resume goes on once it "
        "can be written."
    )
    assert read_result(tmp_path).status == "running"


def test_a_folder_that_cannot_be_entered_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def forbidden(self: Path, *_: object, **__: object) -> bool:
        raise PermissionError(13, "Permission denied", str(self))

    write_result(tmp_path / "result.h5", result())
    monkeypatch.setattr(Path, "is_dir", forbidden)
    ended = CliRunner().invoke(cli, ["show", str(tmp_path / "result.h5")])
    assert told(ended).endswith("can be neither read nor written: permission denied.")


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (["diagnose", "r", "--output", "o"], "interrupted; nothing was written."),
        (["run", "s.toml"], "interrupted; --resume goes on from the last checkpoint."),
        (["converge", "s.toml"], "interrupted; the same command goes on."),
        (["sweep", "s.toml"], "interrupted; the same command goes on."),
        (["import", "m.toml", "--output", "o"], "interrupted; no file is left half written."),
    ],
)
def test_each_command_says_what_its_interruption_leaves(
    monkeypatch: pytest.MonkeyPatch, command: list[str], words: str
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("wirewear.records.read_record", interrupted)
    monkeypatch.setattr("wirewear.kinds.load_any_study", interrupted)
    monkeypatch.setattr("wirewear.sweeps.load_sweep", interrupted)
    monkeypatch.setattr("wirewear.records.importing.import_record", interrupted)
    ended = CliRunner().invoke(cli, command)
    assert ended.exit_code == 130
    assert ended.stderr.strip().endswith(f"wirewear: {words}")
