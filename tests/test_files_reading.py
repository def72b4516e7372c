"""Text, TOML and delimited text are read in one place: the same numbers by the fast reader and line by line."""

import csv
import json
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wirewear.base.delimited import DelimitedLayout, DelimitedText, Numbers, read_delimited
from wirewear.base.errors import RecordError, StudyError
from wirewear.base.reading import read_toml
from wirewear.base.writing import json_text, write_csv

ROOT = Path(__file__).resolve().parent.parent
COMMAND = f"{sys.executable} -m wirewear"

#: As loggers spell numbers, and as they should not.
FIELDS = st.one_of(
    st.floats().map(repr),
    st.floats(-1e6, 1e6).map(lambda x: f"{x:.4f}"),
    st.floats(-1e6, 1e6).map(lambda x: f"{x:+.3e}"),
    st.sampled_from(
        ["", " 1.5", "1_000", "1,5", "1.000,5", ".5", "5.", "nan", "NaN", "inf", "-Infinity", "0x1p3", '"2"']
    ),
)
LAYOUTS = [
    DelimitedLayout(),
    DelimitedLayout(delimiter=";", decimal=","),
    DelimitedLayout(delimiter="\t", header_lines=2, lines_after_names=1),
    DelimitedLayout(delimiter=";", names_line=False),
]


def _shell(line: str, **environment: str) -> subprocess.CompletedProcess[str]:
    # Where standard output is ASCII click writes UTF-8.
    ended = subprocess.run(["sh", "-c", line], cwd=ROOT, env=os.environ | environment, capture_output=True, check=False)
    out, err = (one.decode(errors="replace") for one in (ended.stdout, ended.stderr))
    return subprocess.CompletedProcess(ended.args, ended.returncode, out, err)


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_what_standard_output_cannot_show_is_spelled_plainly(encoding: str) -> None:
    ended = _shell(f"{COMMAND} effects; {COMMAND} effects --json", PYTHONIOENCODING=encoding)
    assert (ended.returncode, ended.stderr) == (0, "")


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize("closed", [">&-", "<&- >&- 2>&-"])
def test_a_closed_standard_output_takes_nothing_and_stops_nothing(tmp_path: Path, closed: str) -> None:
    ended = _shell(f"{COMMAND} new {tmp_path / 'study.toml'} {closed}")
    assert (ended.returncode, ended.stderr) == (0, "")
    assert (tmp_path / "study.toml").read_text(encoding="utf-8").startswith("#")


@pytest.mark.seconds
@pytest.mark.parametrize("asked", ["--version", "effects"])
def test_a_full_standard_output_is_one_sentence(asked: str) -> None:
    ended = _shell(f"{COMMAND} {asked} > /dev/full")
    assert ended.returncode == 2
    assert ended.stderr == "wirewear: the output can be neither read nor written: no space left on device.\n"


def test_json_knows_no_number_that_is_not_finite() -> None:
    told = json_text({"a": [1.0, float("inf"), (float("nan"), "µ")], "b": {"c": -float("inf")}})
    assert json.loads(told, parse_constant=pytest.fail) == {"a": [1.0, None, [None, "µ"]], "b": {"c": None}}


@pytest.mark.parametrize("text", ["=1+1", "+1", "-x", "@sum", "\t=1", "\r=1"])
def test_text_is_no_formula_in_a_table_and_numbers_stay(tmp_path: Path, text: str) -> None:
    rows: list[dict[str, Any]] = [{"name": text, "value": -1.5}, {"name": "wire 1-2", "value": None}]
    with write_csv(tmp_path / "table.csv", rows).open(encoding="utf-8", newline="") as file:
        assert list(csv.reader(file)) == [["name", "value"], [f"'{text}", "-1.5"], ["wire 1-2", ""]]


def text_of(layout: DelimitedLayout, rows: list[tuple[str, str]], names: str = "a{}b") -> DelimitedText:
    assert layout.delimiter is not None
    lines = ["header, with ; anything"] * layout.header_lines
    lines += [names.format(layout.delimiter)] * layout.names_line + ["mm\tN"] * layout.lines_after_names
    lines += [layout.delimiter.join(row) for row in rows]
    return DelimitedText(Path("file.csv"), ("\n".join(lines) + "\n").encode(), layout)


def read(text: DelimitedText, fast: bool) -> Numbers | str | None:
    try:
        return text._fast({"a": 0, "b": 1}) if fast else text._slow({"a": 0, "b": 1}, as_logged=False, clock=None)
    except RecordError as refused:
        return str(refused)


@given(layout=st.sampled_from(LAYOUTS), rows=st.lists(st.tuples(FIELDS, FIELDS), min_size=1, max_size=5))
def test_the_fast_reader_reads_what_the_slow_one_does_or_leaves_it_to_it(
    layout: DelimitedLayout, rows: list[tuple[str, str]]
) -> None:
    text = text_of(layout, rows)
    fast, slow = read(text, fast=True), read(text, fast=False)
    if fast is None:
        return
    assert isinstance(fast, Numbers)
    assert isinstance(slow, Numbers), slow
    for name in "ab":
        np.testing.assert_array_equal(fast.columns[name], slow.columns[name])
    assert [fast.line(row) for row in range(len(rows))] == [slow.line(row) for row in range(len(rows))]


@pytest.mark.parametrize("layout", LAYOUTS)
def test_plain_numbers_of_every_layout_are_read_fast(layout: DelimitedLayout) -> None:
    one = f"1{layout.decimal}5"
    found = read(text_of(layout, [(one, "2"), ("-3", "")]), fast=True)
    assert isinstance(found, Numbers)
    np.testing.assert_array_equal(found.columns["a"], [1.5, -3.0])
    np.testing.assert_array_equal(found.columns["b"], [2.0, math.nan])
    assert found.line(0) == layout.lines_before_rows + 1


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1", "utf-16", "cp1252"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_any_encoding_and_any_end_of_line_give_the_same(tmp_path: Path, encoding: str, end: str) -> None:
    path = tmp_path / "loops.txt"
    path.write_bytes(end.join(["Weg [µm];Kraft", "1,5;2", "", "3;4,25", ""]).encode(encoding))
    text = read_delimited(path, DelimitedLayout(delimiter=";", decimal=",", encoding=encoding))
    assert text.names == ("Weg [µm]", "Kraft")
    numbers = text.numbers({"Kraft": 1})
    np.testing.assert_array_equal(numbers.columns["Kraft"], [2.0, 4.25])
    assert [numbers.line(row) for row in (0, 1)] == [2, 4]


def test_quoted_fields_may_hold_the_delimiter(tmp_path: Path) -> None:
    path = tmp_path / "rows.csv"
    path.write_text('source,"radius, mm"\n"Author, 2019",7\n')
    text = read_delimited(path)
    assert text.names == ("source", "radius, mm")
    assert list(text.rows()) == [(2, ["Author, 2019", "7"])]
    assert text.numbers({"radius": 1}).columns["radius"].tolist() == [7.0]


def test_a_pipe_is_refused_instead_of_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "study.toml")
    with pytest.raises(StudyError, match=r"study\.toml is no ordinary file, as a study file must be\.$"):
        read_toml(tmp_path / "study.toml", StudyError, "study file")
