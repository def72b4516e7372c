"""Experiment records: what is read, what is refused, and what a check says."""

import dataclasses
import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from geometry.arrays import Array
from tests.commands import wirewear
from tests.robustness.record_mutations import small_record
from tests.studies import EXAMPLES
from wirewear import RecordError, check_record, read_record, write_record
from wirewear.records import MeasuredLoop
from wirewear.records.remarks import loop_statistics

NAMES = ("no_gap", "rigid_stated_compliant_rig", "free_play_rig")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, data in small_record().items():
        (tmp_path / name).write_bytes(data)
    return tmp_path


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")


def edit_loops(folder: Path, change: Callable[[list[str]], list[str]]) -> None:
    """Change the fields of every row of the loops."""
    path = folder / "loops.csv"
    header, *rows = path.read_text(encoding="utf-8").splitlines()
    changed = [",".join(change(row.split(","))) for row in rows]
    path.write_text("\n".join([header, *changed, ""]), encoding="utf-8")


def topics(folder: Path) -> dict[str, str]:
    return {remark.topic: remark.text for remark in check_record(read_record(folder)).remarks}


@pytest.mark.seconds
@pytest.mark.parametrize("name", NAMES)
def test_example_records_pass_the_check(name: str) -> None:
    report = check_record(read_record(EXAMPLES / name))
    assert not report.problems
    assert not report.cannot
    assert report.repeats == (1, 2, 3)
    assert report.cycles == (100, 1000, 10_000, 100_000)


def test_a_first_cycle_that_begins_at_rest_is_left_out_and_no_problem(tmp_path: Path) -> None:
    """Of a slider on a spring: from rest it is loaded along a branch that no later cycle has."""
    turns = np.arange(400) / 400.0
    drive = 60.0 * np.sin(2.0 * np.pi * turns)

    def forces(start: float) -> Array:
        """Of a spring of 0.2 N/µm that slides at 1.2 N, from that force on."""
        force, found = start, []
        for step in np.diff(drive, prepend=0.0):
            force = float(np.clip(force + 0.2 * step, -1.2, 1.2))
            found.append(force)
        return np.array(found)

    example = read_record(EXAMPLES / "no_gap")
    loops = tuple(
        MeasuredLoop(repeat, cycle, turns / 3.0, drive, forces(start), None)
        for repeat in (1, 2)
        for cycle, start in ((1, 0.0), (10, 1.2), (100, 1.2))
    )
    read = read_record(write_record(tmp_path / "record", replace(example, loops=loops)))
    assert read.cycles == (10, 100)
    assert any("repeat 1, cycle 1; repeat 2, cycle 1" in note for note in read.notes)
    assert "open loops" not in topics(tmp_path / "record")
    # Where it is all there is, it stays.
    alone = read_record(write_record(tmp_path / "alone", replace(example, loops=loops[::3])))
    assert alone.cycles == (1,)


@pytest.mark.parametrize(
    ("file", "old", "new", "message"),
    [
        ("experiment.toml", "diameter_mm = 0.45", "diameter_um = 450", r"line 5, column 15: .* given as diameter_mm"),
        ("experiment.toml", "normal_load_N = 2.0", "", r"missing key 'normal_load_N' .*line 10"),
        ("experiment.toml", "frequency_Hz = 3.0", 'frequency_Hz = "3"', r"frequency_Hz .*line 13, column 16"),
        ("experiment.toml", '"loops.csv"', '"../loops.csv"', r"must name a file in the record's own folder"),
        ("experiment.toml", "displacement_um = 0.15", "displacement_mm = 1", r"displacement_um, in micrometres"),
        ("loops.csv", "displacement_um", "displacement_mm", r"line 1: the column displacement_um is missing"),
        ("loops.csv", "1,100,4,", "1,100,0,", r"loops.csv, line 3, .* a second time, first on line 2"),
        ("loops.csv", ",time_s,", ",sample,", r"loops.csv, line 1: the column 'sample' is named twice"),
        ("loops.csv", "1,100,4,", "1,100.5,4,", r"loops.csv, line 3, column cycle: the value is 100.5"),
        ("scar_fixed.csv", "1,-130,-120,", "1,-130,deep,", r"scar_fixed.csv, line 2, column y_um: 'deep' is no number"),
    ],
)  # fmt: skip
def test_refusals_name_line_and_what_would_be_right(folder: Path, file: str, old: str, new: str, message: str) -> None:
    edit(folder / file, old, new)
    with pytest.raises(RecordError, match=message):
        read_record(folder)


def test_the_drive_is_held_on_the_sensor_unless_the_record_says_otherwise(folder: Path) -> None:
    assert read_record(folder).tables.conditions.drive == "sensor"
    edit(folder / "experiment.toml", "cycles = 100000", 'cycles = 100000\ndrive = "stroke"')
    assert read_record(folder).tables.conditions.drive == "stroke"
    edit(folder / "experiment.toml", '"stroke"', '"load"')
    with pytest.raises(RecordError, match='must be "sensor" or "stroke"'):
        read_record(folder)


def test_statistics_of_an_elliptic_loop_are_those_of_its_closed_form() -> None:
    turn = 2.0 * np.pi * np.arange(1000) / 1000
    x, q = 4.0 + 50.0 * np.sin(turn), 0.3 + 1.2 * np.sin(turn + 1.0)
    found = loop_statistics([MeasuredLoop(1, 7, turn / (6.0 * np.pi), x, q, np.full(1000, 2.0))])
    expected = {"period_s": 1.0 / 3.0, "normal_force_N": 2.0, "energy_mJ": 0.06 * np.pi * np.sin(1.0), "outliers": 0.0}
    expected |= {"displacement_amplitude_um": 50.0, "displacement_offset_um": 4.0, "displacement_jump": 1e-3 * np.pi}
    expected |= {"force_amplitude_N": 1.2, "force_offset_N": 0.3, "displacement_gap": 0.0, "force_gap": 0.0}
    for name, value in expected.items():
        assert getattr(found, name)[0] == pytest.approx(value, rel=1e-3, abs=1e-4), name


@pytest.mark.first_case
@pytest.mark.parametrize(
    ("topic", "change", "words"),
    [
        ("time", lambda f: [*f[:3], f"{1e3 * float(f[3])}", *f[4:]], "looks like milliseconds"),
        ("time", lambda f: [*f[:3], "0" if f[2] == "128" else f[3], *f[4:]], "Time does not increase"),
        ("saturation", lambda f: [*f[:5], f"{min(float(f[5]), 1.15)}", f[6]], "as a sensor at its stop"),
        ("open loops", lambda f: [*f[:4], f"{float(f[4]) + 0.1 * float(f[2])}", *f[5:]], "does not return"),
        ("missing samples", lambda f: [*f[:5], "" if f[2] == "100" else f[5], f[6]], "4 samples missing"),
        ("outliers", lambda f: [*f[:5], "9" if f[2] in ("100", "200") else f[5], f[6]], "8 outlying samples"),
        ("normal force", lambda f: [*f[:6], ""], "No normal force was measured"),
        ("normal force", lambda f: [*f[:6], "1.5"], "0.75 times the 2 N asked for"),
        ("cycle lists", lambda f: [f[0], "200" if f[:2] == ["2", "100"] else f[1], *f[2:]], "cycles 100, 200"),
        ("drift", lambda f: [*f[:4], f"{float(f[4]) + 9.0 * (f[1] != '100')}", *f[5:]], "middle of the stroke"),
    ],
)  # fmt: skip
def test_what_is_odd_is_remarked(
    folder: Path, topic: str, change: Callable[[list[str]], list[str]], words: str
) -> None:
    assert topic not in topics(folder)
    edit_loops(folder, change)
    assert words in topics(folder)[topic]


def test_a_scar_map_that_ends_within_the_scar_is_a_problem(folder: Path) -> None:
    path = folder / "scar_moving.csv"
    header, *rows = path.read_text(encoding="utf-8").splitlines()
    path.write_text(
        "\n".join([header, *(row for row in rows if float(row.split(",")[1]) < 50.0), ""]), encoding="utf-8"
    )
    assert "cut off the moving wire's scar" in topics(folder)["scars"]


def test_the_command_prints_words_or_json_and_its_exit_code_states_problems(folder: Path) -> None:
    assert json.loads(wirewear("check", folder, "--json").stdout)["repeats"] == [1, 2]
    edit_loops(folder, lambda f: [*f[:5], f"{-float(f[5])}", f[6]])
    assert "Problems" in wirewear("check", folder, code=1).stdout
    gone = wirewear("check", folder / "nowhere", code=2)
    assert re.fullmatch(
        r"wirewear: .*nowhere does not exist: a record is a folder with experiment.toml and CSV files\.\n", gone.stderr
    )


def test_a_record_leaves_nothing_of_the_one_before_it(tmp_path: Path) -> None:
    whole = read_record(EXAMPLES / "no_gap")
    write_record(tmp_path, whole)
    (tmp_path / "notes.txt").write_text("mine")
    write_record(tmp_path, dataclasses.replace(whole, scars=(), evolution=()))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["experiment.toml", "loops.csv", "notes.txt"]


# Checksums


@pytest.fixture
def sealed(folder: Path, tmp_path: Path) -> Path:
    """A record as wirewear writes it."""
    return write_record(tmp_path / "sealed", read_record(folder))


@pytest.mark.parametrize("name", ["loops.csv", "evolution.csv", "scar_moving.csv"])
def test_a_table_that_changed_since_it_was_written_is_refused(sealed: Path, name: str) -> None:
    data = (sealed / name).read_bytes().rstrip()
    (sealed / name).write_bytes(data[:-1] + (b"1" if data[-1:] != b"1" else b"2") + b"\n")
    with pytest.raises(RecordError) as refused:
        read_record(sealed)
    assert str(refused.value) == (
        f"{sealed / name} is not as it was written: it is damaged, or was changed; if that was on purpose, delete the "
        "line of its checksum from experiment.toml."
    )
    lines = (sealed / "experiment.toml").read_text().splitlines(keepends=True)
    (sealed / "experiment.toml").write_text("".join(line for line in lines if name not in line or "sha256" not in line))
    assert "is not as it was written" in topics(sealed)["experiment.toml"]
