"""Crashes, lost runs and work without end of version 8318817."""

import ast
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests import early_faults
from tests.early_faults import (
    PROGRAM,
    ROOT,
    changed,
    command,
    held,
    refused,
    run,
)
from wirewear import read_result

folder, ran, result = early_faults.folder, early_faults.ran, early_faults.result


SMALL_DISK = ("unshare", "-rm", "sh", "-c", 'mount -t tmpfs -o size=64k none "$1" && shift && "$@"', "sh")


@pytest.mark.slow
def test_the_same_numbers_come_out_in_another_folder_and_locale_and_with_two_threads(ran: Path, folder: Path) -> None:
    elsewhere = {"LC_ALL": "C", "PYTHONHASHSEED": "7", "TZ": "Asia/Tokyo"}
    threads = {"OMP_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "2"}
    for variables, to in ((elsewhere, 0.0), (threads, 1e-12)):
        ended = command(folder, "run", "study.toml", "--fidelity", "quick", "--output", str(to), variables=variables)
        assert ended.returncode == 0, ended.stderr
        one, other = (read_result(path / "result.h5").evolution for path in (ran / "o", folder / str(to)))
        for name in one:
            np.testing.assert_allclose(other[name], one[name], rtol=to, err_msg=name)


@pytest.mark.slow
def test_no_code_comes_from_data() -> None:
    found = []
    for package in ("geometry", "solvers", "wirewear"):
        # Machine code that the program itself compiled is kept as numba keeps it, in folders of the user's own.
        for file in {*(ROOT / package).rglob("*.py")} - {ROOT / "solvers" / "kept_code.py"}:
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


@pytest.mark.slow
@pytest.mark.parametrize(
    ("loading", "said"),
    [("wirewear.faces.group", "nothing was written"), ("wirewear.effects", "no file is left half written")],
)
def test_an_interruption_while_the_program_or_a_command_loads_is_one_sentence(loading: str, said: str) -> None:
    code = f"""
import sys

class Interrupting:
    def find_spec(self, name, *_):
        if name == "{loading}":
            raise KeyboardInterrupt

sys.meta_path.insert(0, Interrupting())
from wirewear.faces import main
main()
"""
    ended = subprocess.run([sys.executable, "-c", code, "effects"], capture_output=True, text=True, check=False)
    assert ended.returncode == 130
    assert ended.stderr == f"wirewear: interrupted; {said}.\n"


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
