"""Crashes, lost runs and work without end of version 8318817."""

import shutil
import subprocess
from pathlib import Path

import pytest

from tests import early_faults
from tests.early_faults import (
    EXAM,
    GB,
    PROGRAM,
    changed,
    command,
    held,
    limited,
    refused,
    run,
)
from wirewear import read_result

SMALL_DISK = ("unshare", "-rm", "sh", "-c", 'mount -t tmpfs -o size=64k none "$1" && shift && "$@"', "sh")

folder, ran, result = early_faults.folder, early_faults.ran, early_faults.result


@pytest.mark.slow
def test_a_disk_that_is_full_at_a_checkpoint_is_one_sentence_and_no_crash(folder: Path) -> None:
    (folder / "o").mkdir()
    if (
        shutil.which("unshare") is None
        or subprocess.run([*SMALL_DISK, "o", "true"], cwd=folder, check=False).returncode
    ):
        pytest.skip("this user cannot mount a small disk")
    changed(folder / "study.toml", "cycles = 3\n", "cycles = 30\n")
    arguments = (*PROGRAM, "run", "study.toml", "--fidelity", "quick", "--output", "o/o")
    ended = subprocess.run([*SMALL_DISK, "o", *arguments], cwd=folder, capture_output=True, text=True, check=False)
    sentence = refused(ended)
    assert "cannot write the checkpoint" in sentence
    assert "--resume goes on" in sentence


@pytest.mark.slow
def test_a_run_that_was_killed_before_its_first_result_can_be_resumed(folder: Path) -> None:
    changed(folder / "study.toml", "cycles = 3\n", "cycles = 30\n")
    with held(folder, "checkpoint.h5"):
        pass
    (folder / "o" / "result.h5").unlink(missing_ok=True)
    ended = run(folder, "--resume")
    assert ended.returncode == 0, ended.stderr
    assert read_result(folder / "o" / "result.h5").status == "complete"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"contact_mesh_um = 28.0": "contact_mesh_um = 0.1"}, "give contact_mesh_um = "),
        (
            {
                "cycles = 3\n": "cycles = 1000000000\n",
                "[wear]\n": '[wear]\nupdate = "explicit"\nexplicit_jump_cycles = 0.01\n',
                "3.0e-5": "1e-10",
            },
            "cycle jumps",
        ),
    ],
)
def test_a_study_that_no_machine_holds_is_not_begun(folder: Path, changes: dict[str, str], words: str) -> None:
    for old, new in changes.items():
        changed(folder / "study.toml", old, new)
    assert words in refused(run(folder, before=limited(4 * GB)))


@pytest.mark.slow
def test_an_export_and_a_batch_that_no_machine_holds_are_not_begun(result: Path, tmp_path: Path) -> None:
    samples = ("--repeats", "1000", "--samples", "100000")
    export = command(tmp_path, "export", result.name, "--as-record", "r", *samples, before=limited(4 * GB))
    assert "samples, which take" in refused(export)
    cases = ("make", "b", "--cases", "1000000000", "--seed", "1")
    batch = command(tmp_path, *cases, before=limited(4 * GB), program=EXAM)
    assert "of disk" in refused(batch)
