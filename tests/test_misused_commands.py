"""Options that do not go together, or not with what they are given for: one sentence each, nothing written."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import pytest
from click.testing import CliRunner

from tests.studies import minimal
from tests.synthetic_results import result
from wirewear.faces import cli
from wirewear.results import write_result


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


@pytest.mark.parametrize("options", [["--body", "moving"], ["--integration-points"], ["--no-pictures"]])
def test_options_of_wires_are_refused_for_line_contacts(
    options: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("wirewear.faces.looking.one_run", lambda _: Mock(length_mm=1.0, contact_kind="line-contact"))
    assert f"{options[0]} does not apply to" in refused("fields", tmp_path, "--cycle", "1", *options)


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
