"""Numbers of any length, any text in any field, points at random: one sentence each, never a traceback."""

from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from tests.studies import MINIMAL
from tests.test_import import GERMAN, german, mapped
from tests.test_import import cycle as cycle_of
from wirewear import RecordError, StudyError
from wirewear.base.processes import within
from wirewear.records import MeasuredScar
from wirewear.records.importing import import_record
from wirewear.simulation import Moment, ProgressBar
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


def test_a_pattern_that_would_need_for_ever_is_refused_in_time(
    tmp_path: Path, cycle: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("wirewear.records.importing.sources.PATTERN_s", 0.2)
    (tmp_path / f"cycle_{'1' * 60}_rep1.txt").write_bytes(german(*cycle).encode("latin-1"))
    bad = GERMAN.replace(r"cycle_(?P<cycle>\d+)_rep(?P<repeat>\d+)", r"cycle_(?P<cycle>(\d+)+)x(?P<repeat>\d+)")
    with within(60.0), pytest.raises(RecordError, match="takes too long on the file's name"):
        import_record(mapped(tmp_path, bad))


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
