"""Options that do not go together, or not with what they are given for: one sentence each, nothing written."""

import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import pytest
from click.testing import CliRunner

from tests.studies import MINIMAL, minimal
from tests.synthetic_results import result
from wirewear.faces import cli
from wirewear.records import read_record
from wirewear.results import write_result

SWEEP = """format = 1
name = "s"
study = "study.toml"
design = "grid"
[[vary]]
key = "contact.friction"
values = [0.5, 0.6]
"""
EXAMPLE = Path(__file__).resolve().parent.parent / "studies" / "steel_wires" / "example_records" / "no_gap"


def refused(*arguments: str | Path) -> str:
    """The sentence of a command that refuses."""
    ended = CliRunner().invoke(cli, [str(argument) for argument in arguments])
    assert ended.exit_code == 2, ended.output or ended.exception
    (sentence,) = [line for line in ended.stderr.splitlines() if line.startswith("wirewear: ")]
    assert sentence.endswith(".")
    return sentence


@pytest.fixture
def run(tmp_path: Path) -> Path:
    write_result(tmp_path / "run" / "result.h5", replace(result(), study=minimal()))
    return tmp_path / "run"


@pytest.mark.parametrize("value", ["nan", "inf", "-1", "many"])
@pytest.mark.parametrize(
    "command",
    [
        ["fields", "run", "--cycle"],
        ["strength", "run", "--cycle"],
        ["strength", "run", "--yield-strength"],
        ["strength", "run", "--averaging-length"],
        ["fit", "record", "--output", "o", "--wear-coefficient"],
        ["fit", "record", "--output", "o", "--worn-volume"],
        ["export", "run", "--as-record", "o", "--length"],
        ["maps", "record", "--fatigue-limit"],
        ["calibrate", "study.toml", "--remote-compliance"],
        ["run", "study.toml", "--most-memory"],
    ],
)
def test_what_is_no_number_of_its_range_is_refused(command: Sequence[str], value: str) -> None:
    assert f"'{command[-1]}'" in refused(*command, value)


def test_an_animation_of_one_position_is_refused(run: Path) -> None:
    assert "give --at all" in refused("fields", run, "--cycle", "1", "--animate")
    assert not (run / "fields").exists()


@pytest.mark.parametrize("options", [["--wire", "moving"], ["--integration-points"], ["--no-pictures"]])
def test_options_of_wires_are_refused_for_line_contacts(
    options: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("wirewear.faces.looking.one_run", lambda _: Mock(length_mm=1.0))
    assert f"{options[0]} does not apply to" in refused("fields", tmp_path, "--cycle", "1", *options)


def test_options_of_line_contacts_and_variants_are_refused_for_wires_without(run: Path) -> None:
    out = run.parent / "record"
    assert "--length does not apply to" in refused("export", run, "--as-record", out, "--length", "3")
    assert "leave --variant out" in refused("export", run, "--as-record", out, "--variant", "soft")
    assert not out.exists()


def test_an_exported_simulation_takes_the_place_of_a_simulated_test_but_of_no_measured_one(run: Path) -> None:
    measured = Path(shutil.copytree(EXAMPLE, run.parent / "measured"))
    before = {path.name: path.read_bytes() for path in measured.iterdir()}
    assert "holds the record 'no_gap (simulated)'" in refused("export", run, "--as-record", measured)
    assert {path.name: path.read_bytes() for path in measured.iterdir()} == before
    for _ in range(2):
        if (loops := run.parent / "again" / "loops.csv").exists():
            # As an export that was interrupted may leave it.
            loops.write_text("")
        ended = CliRunner().invoke(cli, ["export", str(run), "--as-record", str(run.parent / "again")])
        assert ended.exit_code == 0, ended.output
    assert read_record(run.parent / "again").tables.metadata.source == "simulated"


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--fidelity", "fine"], "--uncertain makes quick runs: leave --fidelity fine out"),
        (["--cycles-of", "record"], "--cycles-of does not go with --uncertain"),
        (["--overwrite"], "--overwrite does not go with --uncertain"),
        ([], "states no scatter: give standard deviations in [scatter]"),
        (["--fidelity", "quick"], "states no scatter"),
    ],
)
def test_what_runs_for_intervals_do_not_know_is_refused(options: list[str], says: str, tmp_path: Path) -> None:
    (tmp_path / "study.toml").write_text(MINIMAL)
    assert says in refused("run", tmp_path / "study.toml", "--uncertain", "--output", tmp_path / "o", *options)
    assert not (tmp_path / "o").exists()


def test_intervals_of_a_line_contact_are_refused(tmp_path: Path) -> None:
    begun = CliRunner().invoke(cli, ["new", str(tmp_path / "study"), "--kind", "line-contact"])
    assert begun.exit_code == 0, begun.output
    asked = ("run", tmp_path / "study.toml", "--uncertain", "--output", tmp_path / "o")
    assert "it knows crossed wires only" in refused(*asked)


#: Refused where a bar already runs: a table that is none, loads that are none, a journal that is none.
UNDER_A_BAR: dict[tuple[str, ...], str] = {
    ("calibrate", "study.toml", "--loads", "-1"): "must be positive numbers",
    ("sweep", "sweep.toml", "--output", "other"): "cannot be read",
}


@pytest.mark.parametrize("command", UNDER_A_BAR)
def test_off_a_terminal_a_refusal_is_all_that_is_said(
    command: Sequence[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("table.csv").write_text("radius_mm\n6\n")
    Path("study.toml").write_text(MINIMAL)
    Path("sweep.toml").write_text(SWEEP)
    Path("other/rows.jsonl").mkdir(parents=True)
    ended = CliRunner().invoke(cli, command)
    assert ended.exit_code == 2, ended.output
    assert UNDER_A_BAR[tuple(command)] in ended.stderr
    assert ended.stderr.startswith("wirewear: ")
    assert ended.stderr.count("\n") == 1


@pytest.mark.parametrize(
    "options", [["--size", "easy"], ["--study", "s.toml"], ["--fidelity", "quick"], ["--output", "here"]]
)
@pytest.mark.parametrize("named", [[], ["free_play"], ["--json"]])
def test_options_of_a_plot_are_refused_without_one(options: list[str], named: list[str]) -> None:
    assert f"{options[0]} belongs to --plot: give both" in refused("effects", *named, *options)


def test_a_plot_is_no_json() -> None:
    assert "--json does not go with --plot" in refused("effects", "free_play", "--plot", "--json")


@pytest.mark.parametrize(
    ("taken", "says"),
    [
        ("wires.toml", "is a study, and no mapping of measured files: `wirewear run "),
        ("without_kind.toml", "is a study, and no mapping of measured files: `wirewear run "),
        ("line.toml", "is a study, and no mapping of measured files: `wirewear run "),
        ("sweep.toml", "is a sweep, and no mapping of measured files: `wirewear sweep "),
        ("loops.csv", "is a file of measured numbers, and no mapping of measured files: `wirewear new --mapping "),
        (EXAMPLE, "is a record, and no mapping of measured files: `wirewear check "),
        (EXAMPLE / "experiment.toml", f"is a record, and no mapping of measured files: `wirewear check {EXAMPLE}` "),
    ],
)
def test_what_is_taken_for_a_mapping_is_called_what_it_is(taken: str | Path, says: str, tmp_path: Path) -> None:
    for name, kind in (("wires", "crossed-wires"), ("line", "line-contact")):
        begun = CliRunner().invoke(cli, ["new", str(tmp_path / name), "--kind", kind])
        assert begun.exit_code == 0, begun.output
    (tmp_path / "without_kind.toml").write_text(MINIMAL.replace('kind = "crossed-wires"\n', ""))
    (tmp_path / "sweep.toml").write_text(SWEEP)
    (tmp_path / "loops.csv").write_text("x,q\n1,2\n")
    assert says in refused("import", tmp_path / taken, "--output", tmp_path / "record")
    assert not (tmp_path / "record").exists()


@pytest.mark.parametrize(
    ("line", "says"),
    [
        (
            "--diameter 1200",
            "--diameter is 1200.0, but must lie between 0.02 and 20 millimetres: it looks like micrometres",
        ),
        ("--diameter 450e-6", "it looks like metres, which would be 0.45 here"),
        ("--diameter 0.45 --normal-load 20000", "it looks like millinewtons, which would be 20 here"),
        ("--diameter 0.45 --amplitude 0.06", "it looks like millimetres, which would be 60 here"),
        ("--diameter nan", "--diameter is nan, but must be a finite number"),
        ("--length 10 --radius 40000", "--radius is 40000.0, but must lie between"),
    ],
)
def test_what_is_stated_of_a_test_in_another_unit_is_refused(line: str, says: str, tmp_path: Path) -> None:
    (tmp_path / "loops.csv").write_text("x,q\n1,2\n")
    assert says in refused("new", "--mapping", tmp_path / "loops.csv", *line.split())
    assert not (tmp_path / "mapping.toml").exists()


@pytest.mark.parametrize("command", [["strength", "--yield-strength"], ["maps", "--fatigue-limit"]])
def test_a_strength_in_gigapascals_is_refused(command: list[str], run: Path) -> None:
    name, option = command
    assert "it is 0.3, but must lie between 5 and 10000 megapascals: it looks like gigapascals, which would be 300" in (
        refused(name, run, option, "0.3")
    )
