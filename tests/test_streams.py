"""Standard output that is closed or knows only ASCII, faults of the program, and JSON that others can read."""

import csv
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from wirewear.base.writing import json_text, write_csv

ROOT = Path(__file__).resolve().parent.parent
COMMAND = f"{sys.executable} -m wirewear"


def _shell(line: str, **environment: str) -> subprocess.CompletedProcess[str]:
    # Where standard output is ASCII click writes UTF-8.
    ended = subprocess.run(["sh", "-c", line], cwd=ROOT, env=os.environ | environment, capture_output=True, check=False)
    out, err = (one.decode(errors="replace") for one in (ended.stdout, ended.stderr))
    return subprocess.CompletedProcess(ended.args, ended.returncode, out, err)


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_what_standard_output_cannot_show_is_spelled_plainly(encoding: str) -> None:
    ended = _shell(f"{COMMAND} effects; {COMMAND} effects --json", PYTHONIOENCODING=encoding)
    assert (ended.returncode, ended.stderr) == (0, "")


@pytest.mark.parametrize("closed", [">&-", "<&- >&- 2>&-"])
def test_a_closed_standard_output_takes_nothing_and_stops_nothing(tmp_path: Path, closed: str) -> None:
    ended = _shell(f"{COMMAND} new {tmp_path / 'study.toml'} {closed}")
    assert (ended.returncode, ended.stderr) == (0, "")
    assert (tmp_path / "study.toml").read_text(encoding="utf-8").startswith("#")


def test_a_study_is_begun_on_standard_output_where_that_is_asked_for(tmp_path: Path) -> None:
    ended = _shell(f"{COMMAND} new my_wires --output /dev/stdout > {tmp_path / 'study.toml'}")
    assert (ended.returncode, ended.stderr) == (0, "")
    assert (tmp_path / "study.toml").read_text(encoding="utf-8").startswith("#")


@pytest.mark.parametrize("asked", ["--help", "--version", "effects", "run --help"])
def test_a_full_standard_output_is_one_sentence(asked: str) -> None:
    ended = _shell(f"{COMMAND} {asked} > /dev/full")
    assert ended.returncode == 2
    assert ended.stderr == "wirewear: the output can be neither read nor written: no space left on device.\n"


@pytest.mark.parametrize("shown", ["", "1"])
def test_a_fault_of_the_program_is_one_sentence_unless_its_traceback_is_asked_for(shown: str) -> None:
    script = "import sys, wirewear.faces as c, wirewear.faces.commands as d; d.cli = lambda **k: 1 / 0; c.main()"
    ended = _shell(f'{sys.executable} -c "{script}"', WIREWEAR_TRACEBACK=shown)
    assert ended.returncode == 1
    assert ("Traceback" in ended.stderr) == bool(shown)
    assert shown or (ended.stderr.count("\n") == 1 and "ZeroDivisionError" in ended.stderr)


def test_json_knows_no_number_that_is_not_finite() -> None:
    told = json_text({"a": [1.0, float("inf"), (float("nan"), "µ")], "b": {"c": -float("inf")}})
    assert json.loads(told, parse_constant=pytest.fail) == {"a": [1.0, None, [None, "µ"]], "b": {"c": None}}


@pytest.mark.parametrize("text", ["=1+1", "+1", "-x", "@sum", "\t=1", "\r=1"])
def test_text_is_no_formula_in_a_table_and_numbers_stay(tmp_path: Path, text: str) -> None:
    rows: list[dict[str, Any]] = [{"name": text, "value": -1.5}, {"name": "wire 1-2", "value": None}]
    with write_csv(tmp_path / "table.csv", rows).open(encoding="utf-8", newline="") as file:
        assert list(csv.reader(file)) == [["name", "value"], [f"'{text}", "-1.5"], ["wire 1-2", ""]]


def test_tables_are_written_in_one_place() -> None:
    written = {path.name for folder in ("wirewear", "studies") for path in (ROOT / folder).rglob("*.py")
               if re.search(r"\.write_csv\(|csv\.(Dict)?[wW]riter\(", path.read_text(encoding="utf-8"))}  # fmt: skip
    assert written == {"interchange.py"}
