"""Commands of the pages run as they are written, in turn, on files of the names that the pages give them."""

import csv
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
#: Those of the gallery are run by `tools.pictures`.
PAGES = sorted({page for page, _ in lines_of_commands()} - {"gallery.md"})
#: A result of another kind, machines of another network and an exam's batch: they have tests of their own.
ELSEWHERE = ("export RESULT --as-record RECORD --length", "sweep sweep.toml --output DIR --scheduler", "python -m")
STUDY = f"""{LONG.replace("cycles = 400", "cycles = 1000")}
[log]
loop_cycles = [1, 1000]
[variants.rigid.contact]
friction = 0.6
[variants.compliant.holder]
tangential_stiffness_N_per_mm = 167.0
"""
SWEEP = """format = 1
name = "frictions"
design = "sobol"
samples = 2
study = "my_study.toml"
variant = "rigid"
[[vary]]
key = "contact.friction"
low = 0.5
high = 0.6
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
    for name in ("RECORD", "record_1", "record_2", "my_record"):
        shutil.copytree(record, desk / name)
    (desk / "studies").symlink_to(ROOT / "studies")
    wirewear("new", desk / "STUDY.toml", "--from", desk / "RECORD")
    (desk / "study.toml").write_text(STUDY.partition("[variants")[0] + "[scatter]\nfriction = 0.05\n", encoding="utf-8")
    (desk / "sweep.toml").write_text(SWEEP, encoding="utf-8")
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
    lines = [line.removeprefix("wirewear ") for name, line in lines_of_commands() if name == page]
    if page == "records.md":
        Path("test.csv").unlink()  # One kind of logger's file beside the profile.
    if page == "loops.md":
        _with_a_probe(Path("test.csv"))
    if page == "life.md":
        wirewear("run", "studies/rope_wires/study.toml", "--fidelity", "quick", "--output", "runs/rope_wires")
    for line in lines:
        if line.startswith(ELSEWHERE):
            continue
        # Of a sweep that takes long, two runs stand for all.
        words = shlex.split(line.replace("studies/rig_sensitivity/sweep.toml", "sweep.toml"))
        for made in [after for word, after in pairwise(words) if word in MADE]:
            shutil.rmtree(desk / made, ignore_errors=True)
        if "--mapping" in words:
            (Path("FOLDER") if "FOLDER" in words else Path()).joinpath("mapping.toml").unlink(missing_ok=True)
        wirewear(*[found for word in words for found in sorted(map(str, Path().glob(word)) if "*" in word else [word])])
        for name in ("RECORD", "RESULT"):
            if not Path(name).exists():
                shutil.copytree(stock / name, name)


def _with_a_probe(path: Path) -> None:
    """Put the force in mN into the third column of a log, and the displacement in mm into one called x probe."""
    names, *rows = csv.reader(path.read_text(encoding="utf-8").splitlines())
    x, force = names.index("displacement_um"), names.index("tangential_force_N")
    names[2:2] = ["load cell", "x probe"]
    for row in rows:
        row[2:2] = [f"{1e3 * float(row[force]):.2f}", f"{1e-3 * float(row[x]):.5f}"]
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([names, *rows])
