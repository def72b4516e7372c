"""Text, TOML and tables are read the same either way, or refused if too much; files are written in one step."""

import csv
import io
import json
import math
import os
import re
import resource
import struct
import subprocess
import sys
import tracemalloc
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.io import savemat

from tests.records import strangers_files, strangers_maps
from wirewear.base.delimited import DelimitedLayout, DelimitedText, Numbers, read_delimited
from wirewear.base.errors import RecordError, ResultError, RunError, StudyError
from wirewear.base.files import read_toml
from wirewear.base.writing import (
    folder_in_one_step,
    json_text,
    usable_file,
    write_bytes,
    write_csv,
    write_text,
    writing,
)
from wirewear.records.importing.height_maps import height_map
from wirewear.records.importing.mapping import ColumnMapping, Source
from wirewear.records.importing.sources import read_source

ROOT = Path(__file__).parents[2]
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
    assert "tan beta" in ended.stdout


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
    written = json_text({"a": [1.0, float("inf"), (float("nan"), "µ")], "b": {"c": -float("inf")}})
    assert json.loads(written, parse_constant=pytest.fail) == {"a": [1.0, None, [None, "µ"]], "b": {"c": None}}


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


@example(layout=LAYOUTS[2], rows=[("", ""), ("1", "2")])
@given(layout=st.sampled_from(LAYOUTS), rows=st.lists(st.tuples(FIELDS, FIELDS), min_size=1, max_size=5))
def test_the_fast_reader_reads_what_the_slow_one_does(layout: DelimitedLayout, rows: list[tuple[str, str]]) -> None:
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
    found = read(text_of(layout, [(f"1{layout.decimal}5", "2"), ("-3", "")]), fast=True)
    assert isinstance(found, Numbers)
    np.testing.assert_array_equal(found.columns["a"], [1.5, -3.0])
    np.testing.assert_array_equal(found.columns["b"], [2.0, math.nan])
    assert found.line(0) == layout.lines_before_rows + 1


def test_a_pipe_is_refused_instead_of_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "study.toml")
    with pytest.raises(StudyError, match=r"study\.toml is no ordinary file, as a study file must be\.$"):
        read_toml(tmp_path / "study.toml", StudyError, "study file")


HEAD = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM"
BYTES = 15_000_000


def element(kind: int, body: bytes) -> bytes:
    return struct.pack("<II", kind, len(body)) + body


def array(kind: int, dimensions: tuple[int, int], contents: bytes) -> bytes:
    """An array of a class, named x."""
    flags = element(6, struct.pack("<II", kind, 0))
    name = struct.pack("<HH", 1, 1) + b"x\0\0\0"
    return element(14, flags + element(5, struct.pack("<ii", *dimensions)) + name + contents)


def matlab(path: Path) -> None:
    read_source(path, Source(files=(path.name,)), {"displacement_um": ColumnMapping(column="x")})


@pytest.mark.parametrize(
    ("what", "body"),
    [
        ("dimensions that no file holds", array(6, (100_000, 100_000), element(2, bytes(64)))),
        ("a byte each that becomes a number", array(6, (1, BYTES), element(2, bytes(BYTES)))),
        ("cells without end", array(1, (1, 1_000_000), element(14, b"") * 1_000_000)),
    ],
)
def test_a_matlab_file_that_would_fill_memory_is_refused_unread(tmp_path: Path, what: str, body: bytes) -> None:
    path = tmp_path / "loops.mat"
    path.write_bytes(HEAD + element(15, zlib.compress(body, 9)))
    tracemalloc.start()
    with pytest.raises(RecordError, match=r"loops.mat of .* states contents of .*: it is damaged, or made to fill"):
        matlab(path)
    # As many bytes as the refusal itself looks at, and no more.
    assert tracemalloc.get_traced_memory()[1] < 20e6, what
    tracemalloc.stop()


def zipped(path: Path, names: tuple[str, ...], size: int) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as parts:
        for name in names:
            parts.writestr(name, bytes(size))
    return path


def test_a_zipped_map_and_a_spreadsheet_of_zeros_are_refused_before_they_are_unpacked(tmp_path: Path) -> None:
    refusal = r"of \d+ kB states contents of .*: it is damaged, or made to fill the memory"
    with pytest.raises(RecordError, match=refusal):
        height_map(zipped(tmp_path / "map.x3p", ("main.xml", "bindata/data.bin"), 14_000_000))
    with pytest.raises(RecordError, match=refusal):
        read_delimited(zipped(tmp_path / "book.xlsx", ("xl/workbook.xml", "xl/a.xml", "xl/b.xml"), 36_000_000))


@pytest.mark.seconds
def test_a_large_text_that_is_no_map_is_refused_without_being_read(tmp_path: Path) -> None:
    """SurfaceTopography took 160 bytes a byte, and a second a megabyte."""
    path = tmp_path / "map.txt"
    path.write_text(" ".join(["1.25"] * 300) + "\n" + ("1.25 " * 300 + "\n") * 250, encoding="ascii")
    tracemalloc.start()
    with pytest.raises(RecordError, match=r"map.txt"):
        height_map(path)
    assert tracemalloc.get_traced_memory()[1] < 15e6
    tracemalloc.stop()


@pytest.mark.parametrize("step", [5000.0, 0.005], ids=["nm", "mm"])
def test_a_map_of_nanofocus_is_as_wide_as_its_field_in_whichever_unit_it_steps(tmp_path: Path, step: float) -> None:
    """The format says mm; files in public say 312.5 for a field of 160 µm and 512 points."""
    nms = pytest.importorskip("SurfaceTopography.IO.NMS", exc_type=ImportError)
    _, _, heights = strangers_maps.surface()
    low, high = float(heights.min()), float(heights.max())
    data = bytearray(nms._HEADER_SIZE)
    struct.pack_into("<dd", data, nms._OFFSET_Z, low, high)
    struct.pack_into("<IIdd", data, nms._OFFSET_POINTS, strangers_maps.COLUMNS, strangers_maps.ROWS, step, step)
    levels = np.round((heights.T - low) / (high - low) * (2**16 - 2)).astype("<u2")
    stream = io.BytesIO()
    stream.write(bytes(data) + levels.tobytes())
    (tmp_path / "map.nms").write_bytes(stream.getvalue())
    x, y, read = height_map(tmp_path / "map.nms")
    assert np.ptp(x) == pytest.approx(strangers_maps.STEP_um * (strangers_maps.COLUMNS - 1), rel=1e-6)
    assert np.ptp(y) == pytest.approx(strangers_maps.STEP_um * (strangers_maps.ROWS - 1), rel=1e-6)
    np.testing.assert_allclose(read, heights, atol=1e-3)


def test_two_channels_of_one_matlab_matrix_are_asked_for(tmp_path: Path) -> None:
    savemat(tmp_path / "loops.mat", {"hyst": np.stack([strangers_files.X, strangers_files.FORCE], axis=1)})
    source = Source(files=("loops.mat",), kind="matlab")
    both = {name: ColumnMapping(column="hyst") for name in ("displacement_um", "tangential_force_N")}
    asked = "stands for displacement_um and tangential_force_N: say which part of it each one is, such as 'hyst(:,1)'"
    with pytest.raises(RecordError, match=re.escape(asked)):
        read_source(tmp_path / "loops.mat", source, both)
    parts = {name: ColumnMapping(column=f"hyst(:,{place})") for place, name in enumerate(both, 1)}
    read = read_source(tmp_path / "loops.mat", source, parts)
    np.testing.assert_array_equal(read["tangential_force_N"], strangers_files.FORCE)
    with pytest.raises(RecordError, match=r"'hyst\(:,3\)' lies outside of the variable, which is 512 × 2"):
        read_source(tmp_path / "loops.mat", source, {"displacement_um": ColumnMapping(column="hyst(:,3)")})


WRITER = """
import sys
from pathlib import Path
from wirewear.base.writing import in_one_step

with in_one_step(Path(sys.argv[1])) as partial:
    partial.write_text("half of it")
    print("started", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def slow_writer(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """A process that is in the middle of writing result.txt."""
    command = [sys.executable, "-c", WRITER, str(tmp_path / "result.txt")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "started\n"
        yield process
        process.kill()


def test_a_killed_writer_leaves_the_old_file_and_is_cleared(tmp_path: Path, slow_writer: subprocess.Popen[str]) -> None:
    path = tmp_path / "result.txt"
    path.write_text("old")
    slow_writer.kill()
    slow_writer.wait()
    assert path.read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 2
    write_text(path, "new")
    assert [file.name for file in tmp_path.iterdir()] == ["result.txt"]
    assert path.read_text() == "new"


def test_a_file_too_large_for_the_disk_leaves_the_old_one(tmp_path: Path) -> None:
    path = tmp_path / "result.bin"
    write_bytes(path, b"old")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, limits[1]))
    try:
        with (
            pytest.raises(ResultError, match=r"^cannot write it: file too large\.$"),
            writing(ResultError, "cannot write it"),
        ):
            write_bytes(path, bytes(20_000))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert path.read_bytes() == b"old"
    assert [file.name for file in tmp_path.iterdir()] == ["result.bin"]


def test_contents_reach_the_disk_before_the_name_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    steps = []
    synchronise, replace = os.fsync, Path.replace

    def fsync(descriptor: int) -> None:
        steps.append(f"sync {Path(f'/proc/self/fd/{descriptor}').readlink().name}")
        synchronise(descriptor)

    def replaced(self: Path, target: Path) -> Path:
        steps.append(f"name {target.name}")
        return replace(self, target)

    monkeypatch.setattr(os, "fsync", fsync)
    monkeypatch.setattr(Path, "replace", replaced)
    write_text(tmp_path / "result.txt", "new")
    assert re.fullmatch(rf"sync \.result\..*\.partial\.txt, name result\.txt, sync {tmp_path.name}", ", ".join(steps))


def test_a_folder_appears_whole_or_not_at_all(tmp_path: Path) -> None:
    target = tmp_path / "case_001"
    with pytest.raises(ValueError, match="embedded"), folder_in_one_step(target) as partial:
        (partial / "loops.csv\0").write_text("half of it")
    assert not list(tmp_path.iterdir())
    with folder_in_one_step(target) as partial:
        (partial / "loops.csv").write_text("all of it")
        assert not target.exists()
    assert (target / "loops.csv").read_text() == "all of it"
    with pytest.raises(OSError, match="not empty"), folder_in_one_step(target) as partial:
        (partial / "loops.csv").write_text("another")
    assert (target / "loops.csv").read_text() == "all of it"
    assert [folder.name for folder in tmp_path.iterdir()] == ["case_001"]


def test_what_is_no_regular_file_stays_and_is_given_the_text(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.json"
    os.mkfifo(pipe)
    with subprocess.Popen(["cat", str(pipe)], stdout=subprocess.PIPE, text=True) as reader:
        write_text(usable_file(pipe), "written")
        assert reader.communicate()[0] == "written"
    assert pipe.is_fifo()
    assert [one.name for one in tmp_path.iterdir()] == ["pipe.json"]


@pytest.mark.parametrize("exists", [True, False])
def test_a_link_stays_and_what_it_leads_to_is_written(tmp_path: Path, exists: bool) -> None:
    (tmp_path / "elsewhere").mkdir()
    target, first, second = tmp_path / "elsewhere" / "target.txt", tmp_path / "first.txt", tmp_path / "second.txt"
    if exists:
        target.write_text("old")
    first.symlink_to("elsewhere/target.txt")
    second.symlink_to(first)
    write_text(usable_file(second), "new")
    assert target.read_text() == "new"
    assert first.is_symlink()
    assert second.is_symlink()


def test_links_in_a_circle_and_of_others_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    circle, foreign = tmp_path / "circle.txt", tmp_path / "foreign.txt"
    circle.symlink_to(circle)
    foreign.symlink_to(tmp_path / "target.txt")
    with pytest.raises(RunError, match=r"circle\.txt cannot be written: too many levels of symbolic links"):
        usable_file(circle)
    if os.geteuid() == 0:
        os.lchown(foreign, 12345, 12345)
        with pytest.raises(RunError, match=r"foreign\.txt cannot be written: it is a link of another user"):
            usable_file(foreign)
