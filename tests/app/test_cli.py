"""The command line passes on what was asked, and ends foreseeable errors in one sentence and an exit code."""

import os
import pty
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from geometry import GeometryError
from solvers import SolverError
from tests import synthetic_results
from tests.commands import wirewear
from tests.studies import MINIMAL
from wirewear import ResultError, RunError, __version__, write_result
from wirewear.app.cli import SILENCE_s
from wirewear.results import RunResult

VARIANTS = '[variants.rigid.holder]\ntangential_stiffness_N_per_mm = "rigid"\n'


@pytest.fixture
def study_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    # Results go below the folder in which commands are given.
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "my wires" / "study.toml"
    path.parent.mkdir()
    path.write_text(MINIMAL + VARIANTS, encoding="utf-8")
    return path


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Replaces simulation and drawing; holds what they were asked for, and raises what stands under "raises"."""
    asked: dict[str, Any] = {}

    def run_study(study: Any, **options: Any) -> list[RunResult]:
        asked.update(options, study=study)
        if "raises" in asked:
            raise asked["raises"]
        return [synthetic_results.result(variant="compliant", stiffness_N_per_mm=167.0)]

    def show(_results: object, folder: Path, **options: Any) -> list[Path]:
        asked.update(options, folder=folder)
        if "raises" in asked:
            raise asked["raises"]
        return [Path("loops.png"), Path("scars.png")]

    monkeypatch.setattr("wirewear.simulation.run_study", run_study)
    monkeypatch.setattr("wirewear.pictures.show", show)
    return asked


@pytest.mark.seconds
def test_run_takes_standard_fidelity_and_a_folder_named_as_the_study(study_file: Path, asked: dict[str, Any]) -> None:
    wirewear("run", study_file)
    assert (asked["fidelity"], asked["output"], asked["resume"]) == ("standard", Path("runs/my wires"), False)
    assert asked["study"].variant_names == ("rigid",)


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize(
    ("status", "words"), [("complete", "a complete result, and"), ("running", "an unfinished result, and")]
)
@pytest.mark.parametrize("place", ["out", "out/rigid"])
def test_run_takes_the_place_of_no_result_unless_it_is_asked_to(
    study_file: Path, tmp_path: Path, asked: dict[str, Any], status: str, words: str, place: str
) -> None:
    (tmp_path / place).mkdir(parents=True)
    write_result(tmp_path / place / "result.h5", synthetic_results.result(status=status))
    refused = wirewear("run", study_file, "--output", tmp_path / "out", code=2)
    assert words in refused.stderr
    assert refused.stderr.endswith("with --resume, or replace it with --overwrite.\n")
    assert not asked
    for option in ("--resume", "--overwrite"):
        assert wirewear("run", study_file, "--output", tmp_path / "out", option).exit_code == 0


@pytest.mark.parametrize(
    "error",
    [RunError("no space."), ResultError("no result."), GeometryError("a bad element."), SolverError("no convergence.")],
)
def test_errors_of_ours_end_in_a_sentence_and_code_2(study_file: Path, asked: dict[str, Any], error: Exception) -> None:
    asked["raises"] = error
    result = wirewear("run", study_file, code=2)
    assert (result.exit_code, result.stdout, result.stderr) == (2, "", f"wirewear: {error}\n")


def test_what_is_interrupted_within_a_compiled_function_is_interrupted(study_file: Path, asked: dict[str, Any]) -> None:
    fault, within = (SystemError("CPUDispatcher returned a result with an exception set") for _ in range(2))
    fault.__cause__, within.__context__ = within, KeyboardInterrupt()
    asked["raises"] = fault
    stopped = wirewear("run", study_file, code=130)
    assert (stopped.exit_code, stopped.stderr.count("\n")) == (130, 1)
    assert "interrupted; --resume" in stopped.stderr


@pytest.mark.seconds
def test_the_installed_command_prints_its_version_and_a_missing_study_without_a_traceback(tmp_path: Path) -> None:
    command = Path(sys.executable).with_name("wirewear")
    version = subprocess.run([command, "--version"], capture_output=True, text=True, check=True)
    assert __version__ in version.stdout
    missing = subprocess.run([command, "run", "none.toml"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert missing.returncode == 2
    assert missing.stderr == "wirewear: there is no study file none.toml.\n"


def test_help_loads_nothing_that_computes() -> None:
    computing = ["solvers", "numpy", "scipy", "numba", "pydantic", "polars", "h5py", "matplotlib", "rich"]
    heavy = ("geometry.body", *computing)
    code = f"""
import sys
from click.testing import CliRunner
from wirewear.app.cli import cli
assert "Commands:" in CliRunner().invoke(cli, ["--help"]).output
assert "--fidelity" in CliRunner().invoke(cli, ["run", "--help"]).output
print([name for name in {heavy!r} if name in sys.modules])
"""
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout == "[]\n"


@pytest.mark.parametrize(
    ("silence_s", "speaks", "times"),
    [(0.2, "sleep(1.3)", (4, 6)), (0.4, "print('here'); sleep(0.6)", (1, 1)), (9.0, "sleep(0.1)", (0, 0))],
)
def test_a_command_that_is_silent_says_in_time_and_after_equal_pauses_that_it_is_at_work(
    silence_s: float, speaks: str, times: tuple[int, int]
) -> None:
    code = f"from time import sleep; from wirewear.app.cli import speak_up; speak_up('sweep', {silence_s}); {speaks}"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert re.fullmatch(r"(wirewear: sweep is at work(, \d s)?\n)*", ended.stderr)
    assert times[0] <= ended.stderr.count("\n") <= times[1]


def test_that_a_command_is_at_work_stands_on_a_terminal_until_something_else_is_said() -> None:
    code = "from time import sleep; from wirewear.app import cli; cli.speak_up('fit', 0.1); sleep(0.3); print('here')"
    ours, theirs = pty.openpty()
    subprocess.run([sys.executable, "-c", code], stdout=theirs, stderr=theirs, check=True)
    os.close(theirs)
    *before, cleared, last = os.read(ours, 10_000).decode().split("\r")[:-1]
    assert before[-1].startswith("wirewear: fit is at work")
    assert (cleared.strip(), last) == ("", "here")


def test_commands_speak_within_two_seconds() -> None:
    assert SILENCE_s < 2.0
