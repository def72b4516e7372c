"""The same numbers whatever the folder, locale or threads; no code from data; interruptions while the program loads."""

import ast
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from wirewear import read_result

ROOT = Path(__file__).resolve().parent.parent
RUN = ("run", "study.toml", "--fidelity", "quick", "--output")

STUDY = """
kind = "crossed-wires"
format = 1
name = "two coarse wires"
[wires]
diameter_mm = 0.45
youngs_modulus_MPa = 210000.0
poissons_ratio = 0.3
[conditions]
normal_load_N = 2.0
displacement_amplitude_um = 60.0
frequency_Hz = 3.0
cycles = 3
[contact]
friction = 0.62
[wear]
energy_wear_coefficient_mm3_per_J = 3.0e-5
[holder]
tangential_stiffness_N_per_mm = 167.0
[log]
loop_cycles = [1, 3]
[fidelity.quick]
contact_mesh_um = 28.0
increments_per_cycle = 16
"""


def run(folder: Path, output: str, variables: Mapping[str, str]) -> Path:
    """The result of the command, as users give it, on the study in a folder."""
    folder.mkdir()
    (folder / "study.toml").write_text(STUDY)
    ended = subprocess.run(
        [sys.executable, "-c", "from wirewear.faces import main; main()", *RUN, output],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=1200,
        env={**os.environ, **variables},
    )
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
