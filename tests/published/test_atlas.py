"""The fretting atlas: entries, expressions over their tables, predictions before comparisons, the frozen table."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from studies.atlas import commands
from studies.atlas.entry import ALL, Entry, Row, read_entries
from studies.atlas.table import frozen, moved, write_table
from wirewear import StudyError

TABLE = "# source\ntest,use,load_N,energy_J\na,fit,1,2.0\nb,fit,2,4.2\nc,predict,4,9.0\nd,predict,5,\n"
ENTRY = """
name = "made"
citation = "nobody"
licence = "none"
printed = "nothing"
fitted = "use = 'fit'"
[constants]
slope = "SUM(energy_J * load_N) / SUM(load_N * load_N)"
factor = 0.5
[columns]
half = "load_N * factor"
[[compare]]
figure = "energy"
unit = "J"
measured = "energy_J"
simulated = "2 * slope * half + extra"
tolerance = 0.1
why = "made."
[[compare]]
figure = "largest"
unit = "N"
measured = "MAX(load_N)"
simulated = "5.5"
tolerance = 0.05
why = "made."
"""


def made(folder: Path, entry: str = ENTRY, table: str = TABLE) -> Entry:
    (folder / "made").mkdir(parents=True, exist_ok=True)
    (folder / "made" / "entry.toml").write_text(entry, encoding="utf-8")
    (folder / "made" / "tests.csv").write_text(table, encoding="utf-8")
    return Entry.read(folder / "made")


def simulated(row: Mapping[str, Any]) -> dict[str, float]:
    assert row["half"] == 0.5 * row["load_N"]
    return {"extra": 0.0, "load_N": -1.0}


def test_constants_are_of_the_fitted_rows_alone_and_others_are_hidden_until_they_are_predicted(tmp_path: Path) -> None:
    rows = {row.test: row for row in made(tmp_path).rows(simulated) if row.figure == "energy"}
    assert rows["b"].simulated == pytest.approx(2 * (2.0 + 2 * 4.2) / 5)
    assert (rows["a"].measured, rows["c"].measured, rows["c"].error) == (2.0, None, None)
    assert rows["c"].simulated == pytest.approx(8.32)
    to_predict = made(tmp_path).rows(simulated, to_predict=True)
    assert {row.test: row.measured for row in to_predict if row.figure == "energy"} == {"c": None, "d": None}
    (tmp_path / "made" / "predictions.csv").write_text("test,figure,predicted\nc,energy,8.0\n", encoding="utf-8")
    (one,) = (row for row in made(tmp_path).rows(simulated) if (row.test, row.figure) == ("c", "energy"))
    assert (one.measured, one.predicted, one.within) == (9.0, 8.0, False)
    assert one.error == pytest.approx(8.0 / 9.0 - 1.0)


def test_an_expression_of_all_rows_is_one_figure(tmp_path: Path) -> None:
    (row,) = (row for row in made(tmp_path).rows(simulated) if row.figure == "largest")
    assert (row.test, row.measured, row.within) == (ALL, 5.0, False)


@pytest.mark.parametrize(
    ("entry", "table", "message"),
    [
        (ENTRY.replace("2 * slope", "2 * slop"), TABLE, "energy in .*entry.toml cannot be computed: .*slop"),
        (ENTRY.replace("load_N * factor", "load_N *"), TABLE, "is no SQL"),
        (ENTRY.replace("tolerance = 0.1", "tolerence = 0.1"), TABLE, "tolerence"),
        (ENTRY, TABLE.replace("b,fit", "a,fit"), "every name once"),
    ],
)
def test_mistakes_are_stated_in_a_sentence(tmp_path: Path, entry: str, table: str, message: str) -> None:
    with pytest.raises(StudyError, match=message):
        made(tmp_path, entry, table).rows(simulated)


def test_a_prediction_that_is_written_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made(tmp_path, ENTRY.replace(" + extra", ""))
    (tmp_path / "made" / "predictions.csv").write_text("test,figure,predicted\nc,energy,8.0\n", encoding="utf-8")
    monkeypatch.setattr(commands, "read_entries", lambda names: read_entries(names, tmp_path))
    message = CliRunner().invoke(commands.atlas, ["predict", "made", "--output", str(tmp_path / "runs")])
    assert "2 predictions" in message.output
    assert read_entries(["made"], tmp_path)[0].predictions == {("c", "energy"): 8.0, ("d", "energy"): 10.4}


def test_an_unfinished_entry_is_run_once_its_table_has_a_key_of_the_study(tmp_path: Path) -> None:
    prepared = CliRunner().invoke(
        commands.atlas, ["new", "10.1/x", "--name", "mine", "--kind", "crossed-wires", "--into", str(tmp_path)]
    )
    assert prepared.exit_code == 0, prepared.output
    entry = Entry.read(tmp_path / "mine")
    assert "10.1/x" in entry.table.citation
    assert entry.tests["conditions.displacement_amplitude_um"].to_list() == [50.0, 60.0]
    (row,) = (row for row in entry.rows(lambda _: {"accumulated_energy_J": 3.0}) if row.test == "2")
    assert (row.simulated, row.measured) == (3.0, None)
    again = CliRunner().invoke(commands.atlas, ["new", "10.1/x", "--name", "mine", "--into", str(tmp_path)])
    assert again.exit_code != 0


def test_the_frozen_table_holds_every_comparison_that_the_entries_state() -> None:
    held = {(row.entry, row.figure) for row in frozen()}
    stated = {(entry.name, one.figure) for entry in read_entries() for one in entry.table.compare}
    assert stated == held
    predicted = {(row.entry, row.test, row.figure): row.predicted for row in frozen() if row.predicted is not None}
    written = {(e.name, *key): value for e in read_entries() for key, value in e.predictions.items()}
    assert predicted == pytest.approx(written)
    assert len(written) >= 12


def test_what_moves_by_more_than_its_tolerance_is_stated(tmp_path: Path) -> None:
    rows = [Row("e", name, "f", "1", 1.0, None, 1.0, None, 0.1) for name in "ab"]
    before = frozen(write_table(rows, tmp_path / "table.csv"))
    assert before == rows
    now = [Row("e", name, "f", "1", 1.0, None, value, None, 0.1) for name, value in (("a", 1.05), ("b", 1.2))]
    assert moved(now, before) == [(now[1], before[1])]
    assert moved(rows, []) == []


@pytest.mark.slow
def test_two_measured_scars_are_simulated_as_the_frozen_table_has_them(tmp_path: Path) -> None:
    run = CliRunner().invoke(
        commands.atlas, ["run", "mccoll2004", "arnaud2021", "baydoun2019", "--output", str(tmp_path / "runs")]
    )
    assert run.exit_code == 0, run.output
    assert "3 entries" in (tmp_path / "runs" / "atlas.html").read_text(encoding="utf-8")
