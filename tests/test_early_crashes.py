"""Crashes, lost runs and work without end of version 8318817."""

import ast
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests import early_faults
from tests.early_faults import ROOT, command
from wirewear import read_result

folder, ran, result = early_faults.folder, early_faults.ran, early_faults.result


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
