"""Wrong or old answers that version 8318817 gave."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests import early_faults
from tests.early_faults import (
    ROOT,
    changed,
    held,
    refused,
    run,
)
from wirewear import read_result

folder, ran, result = early_faults.folder, early_faults.ran, early_faults.result


@pytest.mark.slow
def test_a_complete_run_is_not_handed_out_by_other_code(folder: Path, ran: Path) -> None:
    shutil.copytree(ran / "o", folder / "o")
    for package in ("geometry", "solvers", "wirewear"):
        shutil.copytree(ROOT / package, folder / package)
    with (folder / "solvers" / "jumps.py").open("a") as file:
        file.write("\n# changed\n")
    code = f"import sys; sys.path.insert(0, {str(folder)!r}); from wirewear.faces import main; main()"
    ended = subprocess.run(
        [sys.executable, "-P", "-c", code, "run", "study.toml", "--fidelity", "quick", "--output", "o", "--resume"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=True,
    )
    assert "another version of the program" in ended.stdout + ended.stderr
    assert read_result(folder / "o" / "result.h5").status == "complete"


@pytest.mark.slow
def test_no_flipped_bit_of_a_checkpoint_goes_unseen(folder: Path) -> None:
    changed(folder / "study.toml", "cycles = 3\n", "cycles = 3000\n")
    with held(folder, "checkpoint.h5", "result.h5"):
        pass
    data = (folder / "o" / "checkpoint.h5").read_bytes()
    for share in (0.5, 0.7, 0.9):
        at = int(share * len(data))
        (folder / "o" / "checkpoint.h5").write_bytes(data[:at] + bytes([data[at] ^ 16]) + data[at + 1 :])
        assert "checkpoint" in refused(run(folder, "--resume"))
