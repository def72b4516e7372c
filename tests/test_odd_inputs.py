"""Numbers of any length, any text in any field, points at random: one sentence each, never a traceback."""

import signal
import time
from dataclasses import replace
from io import StringIO
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from tests.diagnosis_cases import diagnosed, record
from tests.studies import MINIMAL
from tests.test_import import GERMAN, german, mapped
from tests.test_import import cycle as cycle_of
from wirewear import (
    RecordError,
    StudyError,
)
from wirewear.base.processes import within
from wirewear.diagnosis import write_diagnosis
from wirewear.records.importing import import_record
from wirewear.records.values import MeasuredScar
from wirewear.simulation import ProgressBar
from wirewear.simulation.observers import Moment
from wirewear.study import parse_study

cycle = cycle_of


@pytest.mark.parametrize("digits", [309, 400, 5000])
@pytest.mark.parametrize("key", ["cycles", "normal_load_N", "friction"])
def test_a_number_of_any_length_is_out_of_range(digits: int, key: str) -> None:
    line = next(line for line in MINIMAL.splitlines() if line.startswith(f"{key} ="))
    with pytest.raises(StudyError) as refused:
        parse_study(MINIMAL.replace(line, f"{key} = {'9' * digits}"), "s.toml")
    assert len(str(refused.value)) < 200
    if digits < 4300:  # what Python reads
        assert f"is a number of {digits} digits, but must lie between" in str(refused.value)


@pytest.mark.parametrize("encoding", ["zlib", "hex", "rot13", "base64", "idna", "punycode", "undefined"])
def test_an_encoding_that_is_none_of_text_is_refused(tmp_path: Path, cycle: Any, encoding: str) -> None:
    (tmp_path / "cycle_1_rep1.txt").write_bytes(german(*cycle).encode("latin-1"))
    with pytest.raises(RecordError, match="must be an encoding of text such as"):
        import_record(mapped(tmp_path, GERMAN.replace('"latin-1"', f'"{encoding}"')))


@pytest.mark.parametrize("name", ["latin-1", "cp1252", "utf_16", "UTF-16-LE", "utf-32", "shift_jis", "mac_roman"])
def test_an_encoding_of_text_is_taken(tmp_path: Path, cycle: Any, name: str) -> None:
    (tmp_path / "cycle_1_rep1.txt").write_bytes(german(*cycle).replace("ü", "u").encode(name))
    assert import_record(mapped(tmp_path, GERMAN.replace('"latin-1"', f'"{name}"'))).cycles == (1,)


def test_a_pattern_that_would_need_for_ever_is_refused_in_time(
    tmp_path: Path, cycle: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("wirewear.records.importing.sources.PATTERN_s", 0.2)
    (tmp_path / f"cycle_{'1' * 60}_rep1.txt").write_bytes(german(*cycle).encode("latin-1"))
    bad = GERMAN.replace(r"cycle_(?P<cycle>\d+)_rep(?P<repeat>\d+)", r"cycle_(?P<cycle>(\d+)+)x(?P<repeat>\d+)")
    with within(60.0), pytest.raises(RecordError, match="takes too long on the file's name"):
        import_record(mapped(tmp_path, bad))


def test_time_runs_out_in_the_main_thread_only() -> None:
    ran = []

    def aside() -> None:
        with within(0.01):
            ran.append(sum(range(1_000_000)))

    thread = Thread(target=aside)
    thread.start()
    thread.join()
    assert ran
    before = signal.getsignal(signal.SIGVTALRM)
    with pytest.raises(TimeoutError), within(0.05):
        work_for_ever()
    assert signal.getsignal(signal.SIGVTALRM) == before


def work_for_ever() -> None:
    while True:
        pass


def test_what_waits_for_a_busy_machine_is_not_late() -> None:
    with within(0.2):
        time.sleep(0.6)


EVOLUTION = """
[evolution]
files = "evolution.csv"
columns = { cycle = "cycle", repeat = "repeat" }
"""
SCARS = """
[scars.moving]
files = "scar.csv"
columns = { x_um = "x", y_um = "y", depth_um = "d", repeat = "repeat" }
"""


@pytest.mark.parametrize("value", ["nan", "inf", "1e300", "9" * 200, "-1", "1.5"])
@pytest.mark.parametrize(
    ("table", "file", "rows"),
    [
        (EVOLUTION, "evolution.csv", "cycle,repeat\n{},1\n"),
        (EVOLUTION, "evolution.csv", "cycle,repeat\n1,{}\n"),
        (SCARS, "scar.csv", "x,y,d,repeat\n0,0,1,{}\n"),
    ],
)
def test_what_counts_nothing_is_no_cycle_and_no_repeat(
    tmp_path: Path, cycle: Any, table: str, file: str, rows: str, value: str
) -> None:
    (tmp_path / "cycle_1_rep1.txt").write_bytes(german(*cycle).encode("latin-1"))
    (tmp_path / file).write_text(rows.format(value))
    with pytest.raises(RecordError, match=r"(cycle|repeat) is .*, but must be a whole number between 0 and 1e\+\d+\.$"):
        import_record(mapped(tmp_path, GERMAN + table))


def test_a_force_that_no_record_can_hold_is_refused_on_import(tmp_path: Path, cycle: Any) -> None:
    time_s, displacement, force = cycle
    text = german(time_s, displacement, np.where(np.arange(force.size) == 9, 1e200, force))
    (tmp_path / "cycle_1_rep1.txt").write_bytes(text.encode("latin-1"))
    with pytest.raises(RecordError, match=r"tangential_force_N is 1e\+\d+, but must be a number between -100000 and"):
        import_record(mapped(tmp_path, GERMAN))


def test_a_cycle_of_two_hundred_digits_in_a_files_name_is_refused(tmp_path: Path, cycle: Any) -> None:
    (tmp_path / f"cycle_{'9' * 200}_rep1.txt").write_bytes(german(*cycle).encode("latin-1"))
    with pytest.raises(RecordError, match="cycle is 1e\\+200, but must be a whole number between 0 and"):
        import_record(mapped(tmp_path, GERMAN))


def test_points_at_random_are_no_grid_wherever_they_come_from() -> None:
    """On version 8318817, 60 000 of them asked for 26.8 GiB."""
    random = np.random.default_rng(0)
    x, y, depth = random.normal(size=(3, 60_000))
    with pytest.raises(RecordError, match="60000 points of repeat 1 lie on 60000 × 60000 lines, which is no grid"):
        MeasuredScar.from_points(1, "moving", x, y, depth)


@pytest.mark.parametrize("name", ["[/]", "[red]x[/red]", "a [/b] c", "\\[/]"])
def test_a_name_may_look_like_markup(name: str) -> None:
    shown = StringIO()
    console = Console(file=shown, force_terminal=True)
    with ProgressBar(name, console) as bar:
        bar.stage(name)
        bar.moved(Moment(1.0, 2, 0.0, 0.0, 0.5, 1.0))
        bar.note(name)
    assert f"wirewear: {name}" in shown.getvalue()


@pytest.mark.slow
def test_a_name_may_look_like_a_script_on_the_page_of_a_diagnosis(tmp_path: Path) -> None:
    name = "</title><script>alert(1)</script>"
    one = record(repeats=1, evolution=False, normal=False)
    named = replace(one, tables=one.tables.model_copy(update={"name": name}))
    write_diagnosis(diagnosed(named), tmp_path)
    (page,) = tmp_path.glob("*.html")
    assert "alert(1)" in page.read_text()
    assert "<script>alert" not in page.read_text()
