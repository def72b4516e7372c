"""Commands of the pages run as they are written, in turn, on files of the names that the pages give them."""

import shlex
import shutil
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tests.commands import wirewear
from tests.house.test_docs import ROOT, lines_of_commands
from tests.studies import EXAMPLES, LONG

pytestmark = pytest.mark.slow
PAGES = ("tutorial", "records", "studies", "line_contacts", "heat", "inside")
#: A test that runs, and a result of another kind: they have tests of their own.
ELSEWHERE = ("follow ", "export RESULT --as-record RECORD --length")
STUDY = f"""{LONG.replace("cycles = 400", "cycles = 1000")}
[log]
loop_cycles = [1, 1000]
[variants.rigid.contact]
friction = 0.6
[variants.compliant.holder]
tangential_stiffness_N_per_mm = 167.0
"""
#: Words before what a command makes.
MADE = ("--output", "--as-record", "--as-tables")


@pytest.fixture(scope="module")
def stock(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the pages presuppose: a logger's files, records, studies and a run."""
    desk = tmp_path_factory.mktemp("stock")
    record = EXAMPLES / "no_gap"
    for name in ("test.csv", "loop_1.txt"):
        shutil.copy(record / "loops.csv", desk / name)
    repeat, x, y, depth = np.loadtxt(record / "scar_fixed.csv", delimiter=",", skiprows=1).T
    height = -depth - 225.0 + np.sqrt(225.0**2 - x**2)
    np.savetxt(desk / "scar_fixed.xyz", np.stack([x, y, height], axis=1)[repeat == 1])
    shutil.copytree(record, desk / "RECORD")
    (desk / "my_study.toml").write_text(STUDY, encoding="utf-8")
    wirewear("run", desk / "my_study.toml", "--fidelity", "quick", "--output", desk / "runs" / "my_study")
    shutil.copytree(desk / "runs" / "my_study" / "compliant", desk / "RESULT")
    wirewear("new", "--mapping", desk / "test.csv", "--diameter", "0.45")
    (folder := desk / "FOLDER").mkdir()
    mapping = (desk / "mapping.toml").read_text(encoding="utf-8").replace("test.csv", "{test}_raw.csv")
    (folder / "mapping.toml").write_text(mapping, encoding="utf-8")
    shutil.copy(desk / "test.csv", folder / "one_raw.csv")
    (desk / "mapping.toml").unlink()
    shutil.copy(ROOT / "studies" / "atlas" / "mccoll2004" / "record" / "profile_specimen.csv", desk / "profile.csv")
    return desk


@pytest.mark.parametrize("page", PAGES)
def test_the_commands_of_a_page_run_in_turn(
    page: str, stock: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk = tmp_path / "desk"
    shutil.copytree(stock, desk, symlinks=True)
    monkeypatch.chdir(desk)
    lines = [line for name, line in lines_of_commands() if name == f"{page}.md"]
    assert lines
    if page == "records":
        Path("test.csv").unlink()  # One kind of logger's file beside the profile.
    for line in lines:
        words = shlex.split(line)[1:]
        if " ".join(words).startswith(ELSEWHERE):
            continue
        for made in [after for word, after in pairwise(words) if word in MADE]:
            shutil.rmtree(desk / made, ignore_errors=True)
        if "--mapping" in words:
            Path("mapping.toml").unlink(missing_ok=True)
        wirewear(*[found for word in words for found in sorted(map(str, Path().glob(word)) if "*" in word else [word])])
        for name in ("RECORD", "RESULT"):
            if not Path(name).exists():
                shutil.copytree(stock / name, name)
