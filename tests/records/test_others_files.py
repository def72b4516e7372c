"""Code and files of others: packages that raise, data beyond their folder, numbers of any length, any text, points."""

from collections.abc import Callable
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from solvers import SolverError, friction_laws, wear_laws
from solvers.laws import plugins
from tests.diagnosis.diagnosis_cases import record
from tests.records.loop_files import GERMAN, german, mapped
from tests.studies import MINIMAL
from wirewear import RecordError, StudyError, read_record, write_record
from wirewear.base.errors import WirewearError
from wirewear.diagnosis.observe import reduction as observables
from wirewear.diagnosis.observe.reduction import all_observables
from wirewear.effects import all_effects, registry
from wirewear.records import MeasuredScar
from wirewear.records.importing import import_record
from wirewear.records.importing.loggers import readers
from wirewear.records.importing.sources import within
from wirewear.simulation import Moment, ProgressBar
from wirewear.test import parse_study


class BadPoint:
    """An entry point whose module raises."""

    name, value, group = "gremlin", "gremlins:Gremlin", "any"

    def load(self) -> object:
        raise ZeroDivisionError("division by zero\nand more")


@pytest.mark.parametrize(
    ("found", "noun", "error"),
    [
        (all_effects, "effect", StudyError),
        (friction_laws, "friction law", SolverError),
        (wear_laws, "wear law", SolverError),
        (all_observables, "observable", WirewearError),
        (readers, "reader", RecordError),
    ],
)
def test_a_plug_in_that_raises_when_it_is_loaded_is_named(
    monkeypatch: pytest.MonkeyPatch, found: Callable[[], object], noun: str, error: type[Exception]
) -> None:
    monkeypatch.setattr(plugins, "entry_points", lambda **_: [BadPoint()])
    caches = (registry._all_effects, friction_laws, wear_laws, observables._all_observables, readers)
    for cache in caches:
        cache.cache_clear()
    try:
        with pytest.raises(error) as refused:
            found()
    finally:
        monkeypatch.undo()
        for cache in caches:
            cache.cache_clear()
    assert str(refused.value).removesuffix(".") == (
        f"the {noun} 'gremlin' of an installed package cannot be loaded from gremlins:Gremlin (ZeroDivisionError: "
        "division by zero): mend or uninstall that package"
    )


def outside(tmp_path: Path) -> Path:
    """A file that no record and no mapping may quote."""
    secret = tmp_path / "secret.csv"
    secret.write_text("root:x:0:0:hidden words\n")
    return secret


@pytest.mark.parametrize("name", ["/etc/passwd", "../secret.csv", "a/../../secret.csv"])
def test_a_mapping_names_no_file_outside_its_folder(tmp_path: Path, name: str) -> None:
    outside(tmp_path)
    (tmp_path / "lab").mkdir()
    with pytest.raises(RecordError, match="must name files beside the mapping or in folders there") as refused:
        import_record(mapped(tmp_path / "lab", GERMAN.replace("cycle_*.txt", name)))
    assert "hidden" not in str(refused.value)


def test_links_out_of_a_folder_are_not_followed(tmp_path: Path, cycle: Any) -> None:
    secret, lab = outside(tmp_path), tmp_path / "lab"
    lab.mkdir()
    (lab / "cycle_1_rep1.txt").symlink_to(secret)
    with pytest.raises(RecordError, match=r"leads out of the folder .*lab, which is not followed\.$") as refused:
        import_record(mapped(lab, GERMAN))
    assert "hidden" not in str(refused.value)
    folder = write_record(tmp_path / "record", record(repeats=1, evolution=False, normal=False))
    (folder / "loops.csv").unlink()
    (folder / "loops.csv").symlink_to(secret)
    with pytest.raises(RecordError, match=r"loops in \[files\] .* leads out of the folder"):
        read_record(folder)


@pytest.mark.parametrize("digits", [309, 400, 5000])
@pytest.mark.parametrize("key", ["cycles", "normal_load_N", "friction"])
def test_a_number_of_any_length_is_out_of_range(digits: int, key: str) -> None:
    line = next(line for line in MINIMAL.splitlines() if line.startswith(f"{key} ="))
    with pytest.raises(StudyError) as refused:
        parse_study(MINIMAL.replace(line, f"{key} = {'9' * digits}"), "s.toml")
    assert len(str(refused.value)) < 200
    if digits < 4300:  # what Python reads
        assert f"is a number of {digits} digits, but must lie between" in str(refused.value)


def test_a_pattern_that_needs_for_ever_is_refused(tmp_path: Path, cycle: Any, monkeypatch: pytest.MonkeyPatch) -> None:
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
def test_what_counts_nothing_is_none(tmp_path: Path, cycle: Any, table: str, file: str, rows: str, value: str) -> None:
    (tmp_path / "cycle_1_rep1.txt").write_bytes(german(*cycle).encode("latin-1"))
    (tmp_path / file).write_text(rows.format(value))
    with pytest.raises(RecordError, match=r"(cycle|repeat) is .*, but must be a whole number between 0 and 1e\+\d+\.$"):
        import_record(mapped(tmp_path, GERMAN + table))


def test_points_at_random_are_no_grid_wherever_they_come_from() -> None:
    """On version 8318817, 60 000 of them asked for 26.8 GiB."""
    x, y, depth = np.random.default_rng(0).normal(size=(3, 60_000))
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
