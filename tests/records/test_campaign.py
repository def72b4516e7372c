"""A folder of tests imported by one mapping: which tests there are, what each states, what is wrong with some."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from tests.browser import page_faults
from tests.records.strangers_files import FORCE, FRICTION, GERMAN, LOAD_N, TIME, AMPLITUDE_um, FREQUENCY_Hz, X, table
from wirewear.app.cli import cli
from wirewear.base.errors import RecordError
from wirewear.records.importing.campaign import campaign_tests

pytestmark = pytest.mark.seconds
NAMES = [f"V{number}" for number in range(1, 7)]
MAPPING = f"""format = 1
name = "Versuche"
[wires]
diameter_mm = 0.45
crossing_angle_deg = 90.0
youngs_modulus_MPa = 210000.0
poissons_ratio = 0.3
[conditions]
displacement_amplitude_um = {AMPLITUDE_um}
frequency_Hz = {FREQUENCY_Hz}
cycles = 4
rig_height_m = 2.0
[loops]
files = "{{test}}_Rohdaten.csv"
delimiter = "semicolon"
decimal = ","
columns = {{ displacement_um = "Weg", tangential_force_N = "Reibkraft", time_s = "Zeit" }}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Six tests of loads of their own; the force of one is half as large again, the file of another is cut off."""
    home = tmp_path / "campaign"
    home.mkdir()
    (home / "mapping.toml").write_text(MAPPING, encoding="utf-8")
    stated = ["test;normal_load_N"]
    for number, name in enumerate(NAMES, 1):
        load = LOAD_N * (1 + number % 3)
        force = load / LOAD_N * FORCE * (1.5 if name == "V3" else 1.0)
        text = "Zeit;Weg;Reibkraft\n" + table((TIME, X, force), GERMAN)
        (home / f"{name}_Rohdaten.csv").write_text(text[:40] if name == "V2" else text, encoding="utf-8")
        stated.append(f"{name};{load:g},0")
    (home / "tests.csv").write_text("\n".join(stated) + "\n", encoding="utf-8")
    return home


def invoked(*words: object) -> Result:
    return CliRunner().invoke(cli, ["lab", *map(str, words)], catch_exceptions=False)


def test_each_test_is_read_with_its_own_load_and_spoiled_ones_are_named(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    answer = invoked(folder, "--output", out)
    assert answer.exit_code == 0, answer.output
    with (out / "lab.csv").open(encoding="utf-8") as file:
        rows = {row["test"]: row for row in csv.DictReader(file)}
    assert list(rows) == NAMES
    assert [name for name, row in rows.items() if row["state"] == "not read"] == ["V2"]
    assert "V2_Rohdaten.csv" in rows["V2"]["remarks"]
    assert [name for name, row in rows.items() if row["state"] == "apart"] == ["V3"]
    assert "friction" in rows["V3"]["remarks"]
    for number, name in enumerate(NAMES, 1):
        if name not in ("V2", "V3"):
            assert float(rows[name]["normal_load_N"]) == pytest.approx(LOAD_N * (1 + number % 3))
            assert float(rows[name]["friction"]) == pytest.approx(FRICTION, rel=0.02)
    assert answer.stderr.count("unknown key") == 1
    page = (out / "lab.html").read_text(encoding="utf-8")
    assert "stands apart" in page
    assert "5 tests: 5 in gross slip" in page


def test_given_again_only_what_has_changed_is_read(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    invoked(folder, "--output", out)
    kept, changed = (out / "records" / name / "loops.csv" for name in ("V1", "V6"))
    before = kept.stat().st_mtime_ns, changed.stat().st_mtime_ns
    (folder / "V2_Rohdaten.csv").write_bytes((folder / "V5_Rohdaten.csv").read_bytes())
    with (folder / "V6_Rohdaten.csv").open("a", encoding="utf-8") as file:
        file.write("\n")
    answer = json.loads(invoked(folder, "--output", out, "--json").stdout)
    assert {row["test"]: row["state"] for row in answer} == dict.fromkeys(NAMES, "good") | {"V3": "apart"}
    assert (kept.stat().st_mtime_ns, changed.stat().st_mtime_ns > before[1]) == (before[0], True)


def bowl(depth_um: float) -> tuple[str, float]:
    """Points of an elliptic bowl as CSV, and its volume in mm³."""
    x, y = np.meshgrid(np.linspace(-150.0, 150.0, 61), np.linspace(-100.0, 100.0, 41), indexing="ij")
    depth = depth_um * np.maximum(1.0 - (x / 100.0) ** 2 - (y / 60.0) ** 2, 0.0)
    rows = (f"{a:g},{b:g},{d:.5f}" for a, b, d in zip(x.ravel(), y.ravel(), depth.ravel(), strict=True))
    return "\n".join(["x,y,depth", *rows]) + "\n", 1e-9 * 0.5 * np.pi * 100.0 * 60.0 * depth_um


@pytest.mark.slow
def test_scars_of_all_tests_stand_side_by_side_with_their_volumes(folder: Path, tmp_path: Path) -> None:
    columns = '{ x_um = "x", y_um = "y", depth_um = "depth" }'
    scars = "".join(
        f'[scars.{body}]\nfiles = "{{test}}_{body}.csv"\nframe = "test"\ncolumns = {columns}\n'
        for body in ("moving", "fixed")
    )
    (folder / "mapping.toml").write_text(MAPPING + scars, encoding="utf-8")
    volumes = {}
    for number, name in enumerate(NAMES, 1):
        text, volumes[name] = bowl(2.0 + number)
        for body in ("moving", "fixed"):
            (folder / f"{name}_{body}.csv").write_text(text[:60] if name == "V5" else text, encoding="utf-8")
    out = tmp_path / "out"
    answer = invoked(folder, "--output", out)
    assert answer.exit_code == 0, answer.output
    with (out / "lab.csv").open(encoding="utf-8") as file:
        rows = {row["test"]: row for row in csv.DictReader(file)}
    assert [name for name, row in rows.items() if row["state"] == "not read"] == ["V2", "V5"]
    for name in ("V1", "V4", "V6"):
        assert float(rows[name]["volume_mm3"]) == pytest.approx(2.0 * volumes[name], rel=0.03)
    page = (out / "lab.html").read_text(encoding="utf-8")
    for body in ("moving", "fixed"):
        assert f"Scars of the {body} wire" in page
    assert all(f"{name}: " in page for name in ("V1", "V3", "V4", "V6"))
    assert page_faults(out / "lab.html") == []


@pytest.mark.parametrize(
    ("pattern", "files"),
    [
        ("{test}.csv", ["a 1.csv", "b.csv", "c.txt"]),
        ("{test}/loops_*.csv", ["a 1/loops_1.csv", "a 1/loops_2.csv", "b/loops_1.csv", "c/scar.csv"]),
        ("{test}/{test}_raw.csv", ["a 1/a 1_raw.csv", "b/b_raw.csv", "c/b_raw.csv"]),
        ("raw/*-{test}.csv", ["raw/2026-a 1.csv", "raw/2026-b.csv", "raw/c"]),
    ],
)
def test_tests_are_found_by_the_names_of_their_files(tmp_path: Path, pattern: str, files: list[str]) -> None:
    (tmp_path / "mapping.toml").write_text(f'[loops]\nfiles = "{pattern}"\n', encoding="utf-8")
    for name in files:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("", encoding="utf-8")
    (tmp_path / "tests.csv").write_text("test,normal_load_N\nb,2\n", encoding="utf-8")
    assert [(test.name, dict(test.stated)) for test in campaign_tests(tmp_path)] == [
        ("a 1", {}), ("b", {"normal_load_N": 2.0})
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("mapping", "stated", "said"),
    [
        (None, None, "has no mapping.toml"),
        ('[loops]\nfiles = "a.csv"\n', None, "names no {test}"),
        ('[loops]\nfiles = "{test}.dat"\n', None, "no file below"),
        ('[loops]\nfiles = "{test}.csv"\n', "name,load\na,1\n", "a column named test"),
        ('[loops]\nfiles = "{test}.csv"\n', "test,normal_load_N\na,1\na,2\n", "twice"),
        ('[loops]\nfiles = "{test}.csv"\n', "test,normal_load_N\na,1,5\n", "more fields"),
    ],
)
def test_a_folder_that_is_no_campaign_gets_one_sentence(
    tmp_path: Path, mapping: str | None, stated: str | None, said: str
) -> None:
    (tmp_path / "a.csv").write_text("", encoding="utf-8")
    for name, text in (("mapping.toml", mapping), ("tests.csv", stated)):
        if text is not None:
            (tmp_path / name).write_text(text, encoding="utf-8")
    with pytest.raises(RecordError, match=said):
        campaign_tests(tmp_path)


def test_an_output_among_the_tests_is_refused(folder: Path) -> None:
    answer = invoked(folder, "--output", folder / "out")
    assert answer.exit_code == 2
    assert "choose another --output" in answer.output


def logged(stroke_um: float) -> str:
    header = "Zeit (s);Weg (um);Reibkraft (N);Normalkraft (N)\n"
    return header + table((TIME, X * stroke_um / AMPLITUDE_um, FORCE, np.full_like(X, LOAD_N)), GERMAN)


@pytest.mark.first_case
@pytest.mark.parametrize("form", ["{}_raw.csv", "{}/raw.csv"])
def test_a_folder_of_tests_gives_one_mapping_and_what_differs_between_them(tmp_path: Path, form: str) -> None:
    strokes = {"T1": 20.0, "T2": 30.0, "T10": 20.0}
    for name, stroke in strokes.items():
        place = tmp_path / "campaign" / form.format(name)
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(logged(stroke), encoding="utf-8")
        place.with_name(place.name.replace("raw", "fixed")).write_text(
            bowl(3.0)[0].replace("x,y,depth", "x_um,y_um,depth_um"), encoding="utf-8"
        )
    home = tmp_path / "campaign"
    (home / "T3_raw.csv" if "_" in form else home / "T3" / "raw.csv").parent.mkdir(exist_ok=True)
    home.joinpath(form.format("T3")).write_text("torn", encoding="utf-8")
    answer = CliRunner().invoke(cli, ["new", "--mapping", str(home), "--diameter", "0.45"], catch_exceptions=False)
    assert answer.exit_code == 0, answer.output
    assert "3 tests: T1, T2, T10" in answer.output
    assert "T3 cannot be read" in answer.output
    with (home / "tests.csv").open(encoding="utf-8") as file:
        rows = {row["test"]: row for row in csv.DictReader(file)}
    assert {name: float(row["displacement_amplitude_um"]) for name, row in rows.items()} == pytest.approx(
        strokes, rel=0.01
    )
    assert set(rows["T1"]) == {"test", "displacement_amplitude_um"}
    assert [one.name for one in campaign_tests(home)] == ["T1", "T2", "T3", "T10"]
    out = tmp_path / "out"
    assert invoked(home, "--output", out).exit_code == 0
    with (out / "lab.csv").open(encoding="utf-8") as file:
        rows = {row["test"]: row for row in csv.DictReader(file)}
    assert [name for name, row in rows.items() if row["state"] == "not read"] == ["T3"]
    refused = CliRunner().invoke(cli, ["new", "--mapping", str(home), "--diameter", "0.45"])
    assert (refused.exit_code, refused.stdout) == (2, "")
    assert "exists already" in refused.stderr


@pytest.mark.parametrize("torn", [True, False])
def test_a_test_without_a_row_is_named_for_its_torn_file_or_for_the_row(
    torn: bool, folder: Path, tmp_path: Path
) -> None:
    rows = (folder / "tests.csv").read_text(encoding="utf-8").splitlines()
    (folder / "tests.csv").write_text("\n".join(row for row in rows if not row.startswith("V4")), encoding="utf-8")
    if torn:
        (folder / "V4_Rohdaten.csv").write_text("torn", encoding="utf-8")
    said = next(line for line in invoked(folder, "--output", tmp_path / "out").stderr.splitlines() if "V4" in line)
    assert ("V4_Rohdaten.csv" in said, "has no row of V4" in said) == (torn, not torn)


def test_files_of_one_stem_are_one_test(tmp_path: Path) -> None:
    for name in ("T1", "T2"):
        (tmp_path / f"{name}.csv").write_text(logged(20.0), encoding="utf-8")
    (tmp_path / "T1.txt").write_text(bowl(3.0)[0].replace("x,y,depth", "x_um,y_um,depth_um"), encoding="utf-8")
    answer = CliRunner().invoke(cli, ["new", "--mapping", str(tmp_path), "--diameter", "0.45"], catch_exceptions=False)
    assert "2 tests: T1, T2" in answer.output
    mapping = (tmp_path / "mapping.toml").read_text(encoding="utf-8")
    assert "{test}.csv" in mapping
    assert "{test}.txt" in mapping
