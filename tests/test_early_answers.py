"""Wrong or old answers that version 8318817 gave."""

import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from random import Random

import pytest

from tests import early_faults
from tests.early_faults import (
    ROOT,
    STUDY,
    changed,
    command,
    held,
    refused,
    run,
)
from wirewear import ResultError, read_result

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
def test_no_changed_byte_of_a_result_goes_unseen(result: Path) -> None:
    data, random = result.read_bytes(), Random(1)
    for _ in range(50):
        at = random.randrange(len(data))
        result.write_bytes(data[:at] + bytes([data[at] ^ random.randrange(1, 256)]) + data[at + 1 :])
        with pytest.raises(ResultError):
            read_result(result)


@pytest.mark.slow
def test_of_two_runs_into_one_folder_at_once_the_second_is_refused(folder: Path) -> None:
    changed(folder / "study.toml", "cycles = 3\n", "cycles = 3000\n")
    (folder / "other").mkdir()
    (folder / "other" / "study.toml").write_text(STUDY)
    with held(folder, "result.h5") as first:
        second = command(folder, "run", "other/study.toml", "--fidelity", "quick", "--output", "o")
        assert first.poll() is None
    assert refused(second)


@pytest.mark.slow
def test_nothing_of_an_older_time_series_stays_beside_a_new_one(folder: Path, ran: Path) -> None:
    shutil.copytree(ran / "o", folder / "o")
    (folder / "o" / "result.h5").unlink()
    changed(folder / "study.toml", "cycles = 3\n", "cycles = 1\n")
    changed(folder / "study.toml", "[1, 3]", "[1]")
    assert run(folder).returncode == 0
    series = {path.name for path in (folder / "o" / "vtk").glob("*.vtu")}
    assert series < {path.name for path in (ran / "o" / "vtk").glob("*.vtu")}


NO_GAP = ROOT / "studies" / "steel_wires" / "example_records" / "no_gap"


def deepened(line: list[str]) -> list[str]:
    return [*line[:-1], str(float(line[-1]) + 5e3)]


def turned(line: list[str]) -> list[str]:
    return [*line[:5], str(-float(line[5])), *line[6:]]


@pytest.mark.slow
@pytest.mark.parametrize(("pattern", "change"), [("scar_*.csv", deepened), ("loops.csv", turned)])
def test_no_diagnosis_is_made_of_a_record_that_cannot_be(
    tmp_path: Path, pattern: str, change: Callable[[list[str]], list[str]]
) -> None:
    for path in shutil.copytree(NO_GAP, tmp_path / "record").glob(pattern):
        header, *lines = path.read_text().splitlines()
        assert pattern != "loops.csv" or header.split(",")[5] == "tangential_force_N"
        path.write_text("\n".join([header, *(",".join(change(line.split(","))) for line in lines), ""]))
    table = tmp_path / "record" / "experiment.toml"
    table.write_text("\n".join(line for line in table.read_text().splitlines() if not line.startswith("# sha256")))
    assert refused(command(tmp_path, "diagnose", "record", "--output", "o"))


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
