"""Cycles numbered in words, by columns, blocks of a file and sheets of a workbook: read, or named as not read."""

import io
import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import openpyxl
import pytest

from geometry.arrays import Array
from tests.records.loop_files import HEAD, STEEL
from tests.records.strangers_files import STIFFNESS_N_per_um, loops
from wirewear.base.blocks import counts_in
from wirewear.base.errors import RecordError
from wirewear.records.importing import guessing, import_record
from wirewear.records.importing.guessed_scars import Touching
from wirewear.records.importing.loop_sources import read_loops

CYCLES, FORCES_N = (1, 100, 1000, 5000), (0.8, 0.9, 1.0, 1.24)
TIME, X, _ = (own[:128] for own in loops())


def force(limit: float) -> Array:
    """One loop of a slider on a spring."""
    found, at = [], 0.0
    for step in np.diff(np.concatenate([X, X]), prepend=0.0):
        at = float(np.clip(at + STIFFNESS_N_per_um * step, -limit, limit))
        found.append(at)
    return np.array(found[X.size :])


#: What a mapping says of sheets that are numbered.
BLOCKS = "\nblocks = true\nheader_lines = 1"

LOOPS = [force(limit) for limit in FORCES_N]


def rows(own: Array, label: str | None = None, sign: str = ",") -> str:
    """Lines of the displacement and a force, perhaps with a label before them."""
    before = [] if label is None else [label]
    numbers = zip(X, own, strict=True)
    lines = (sign.join([*before, f"{x:.4f}", f"{q:.5f}"]) for x, q in numbers)
    return "\n".join(line.replace(".", ",") if sign == ";" else line for line in lines) + "\n"


Titled = tuple[str, Sequence[Sequence[object]], Array]


def workbook(path: Path, sheets: Sequence[Titled]) -> Path:
    """Sheets of a title, lines above the numbers, and a force."""
    book = openpyxl.Workbook()
    book.remove(book.worksheets[0])
    for title, head, own in sheets:
        sheet = book.create_sheet(title)
        for line in head:
            sheet.append(list(line))
        for x, q in zip(X.tolist(), own.tolist(), strict=True):
            sheet.append([x, q])
    book.save(path)
    return path


def guess(path: Path) -> guessing.GuessedMapping:
    known = {"diameter_mm": 0.45, "normal_load_N": 2.0, "frequency_Hz": 3.0}
    return guessing.guessed_mapping([path], known, Touching.of("crossed-wires", known, STEEL, {}))


def require_right(path: Path, repeats: Sequence[int] = (1, 1, 1, 1), cycles: Sequence[int] = CYCLES) -> None:
    """See that both commands read all loops under their numbers."""
    found = read_loops(path, normal_load="2")
    assert [(loop.repeat, loop.cycle) for loop in found] == list(zip(repeats, cycles, strict=True))
    message = guess(path)
    assert message.tables["conditions"]["cycles"] == max(cycles)
    mapping = path.with_name("mapping.toml")
    mapping.write_text(guessing.mapping_text(message), encoding="utf-8")
    record = import_record(mapping)
    assert [(loop.repeat, loop.cycle) for loop in record.loops] == list(zip(repeats, cycles, strict=True))
    for loop, limit in zip(record.loops, FORCES_N, strict=True):
        expected = 4e-3 * limit * (60.0 - limit / STIFFNESS_N_per_um)
        assert loop.figures(2.0).dissipated_energy_mJ.value == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize(
    ("head", "label"),
    [
        ("Cycle Label", '"Cycle {}"'),
        ("Block", "N={}"),
        ("Comment", "{}th cycle"),
        ("Cycle no.", "{}"),
        ("Elapsed cycles", "{}.0"),
        ("Zyklus-Nr.", "Zyklus Nr. {}"),
        ("Stage", "サイクル{}"),
        ("Этап", "цикл № {}"),
        ("Schritt", "Lastspiel {}"),
    ],
)
@pytest.mark.parametrize("sign", [",", ";"])
def test_a_column_that_numbers_cycles_in_words_is_read(tmp_path: Path, head: str, label: str, sign: str) -> None:
    path = tmp_path / "log.csv"
    text = sign.join([head, "Displacement um", "Force N"]) + "\n"
    parts = (rows(own, label.format(n).replace(".0", ""), sign) for n, own in zip(CYCLES, LOOPS, strict=True))
    path.write_text(text + "".join(parts), encoding="utf-8")
    require_right(path)


def test_counts_of_thousands_need_no_word_beside_them(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    text = "Cycle,Displacement um,Force N\n"
    parts = (rows(own, label) for label, own in zip(("1", "0.1k", "1k", "5 k"), LOOPS, strict=True))
    path.write_text(text + "".join(parts), encoding="utf-8")
    require_right(path)


@pytest.mark.parametrize(
    ("labels", "counts"),
    [
        (["Cycle 1", "Cycle 100", "Cycle 1.000", "Cycle 12.500"], [1, 100, 1000, 12500]),
        (["N = 1e2", "N=1E4", "N=5×10^4"], [100, 10000, 50000]),
        (["cycle 10k", "cycle 1.5 k", "cycle 2M"], [10000, 1500, 2000000]),
        (["Cycle 100 of 5000", "Cycle 200 of 5000"], [100, 200]),
        (["Total cycles: 5000 Cycle: 100", "Total cycles: 5000 Cycle: 200"], [100, 200]),
        (["Cycle 1.000", "Cycle 2.000"], None),
        (["ok", "Cycle 2"], None),
        (["N2", "C"], None),
        (["Cycle 1.5", "Cycle 2"], None),
    ],
)
def test_numbers_in_words_are_those_of_whole_cycles(labels: list[str], counts: list[int] | None) -> None:
    assert counts_in(labels, "cycle") == counts


@pytest.mark.parametrize("again", [True, False])
@pytest.mark.parametrize("label", ["Cycle {}", "# Zyklus: {}", "[N = {}]", "Cycle number:;{}", "--- loop no. {} ---"])
def test_blocks_of_a_file_are_read_as_their_cycles(tmp_path: Path, again: bool, label: str) -> None:
    names, path = "Displacement (um);Force (N)\n", tmp_path / "log.csv"
    parts = (
        f"{label.format(n)}\n{names if again or n == 1 else ''}{rows(own, sign=';')}\n"
        for n, own in zip(CYCLES, LOOPS, strict=True)
    )
    path.write_text("Machine 7\n\n" + "".join(parts), encoding="utf-8")
    require_right(path)


@pytest.mark.parametrize("every", [90, 128, 300])
@pytest.mark.parametrize(("head", "clock"), [("", False), ("Machine 7\n\n", True)])
def test_names_that_are_repeated_within_a_table_part_no_cycles(
    tmp_path: Path, every: int, head: str, clock: bool
) -> None:
    step_s, x, q = TIME[1] - TIME[0], np.tile(X, 4), np.concatenate([LOOPS[0]] * 4)
    times = [f"12:59:{58 + n * step_s:07.4f}" if clock else f"{n * step_s:.5f}" for n in range(x.size)]
    lines = [f"{t},{own:.4f},{force:.5f}\n" for t, own, force in zip(times, x, q, strict=True)]
    parts = ("".join(lines[n : n + every]) for n in range(0, len(lines), every))
    path = tmp_path / "log.csv"
    path.write_text(head + "".join(f"Time,Displacement,Force\ns,um,N\n{part}" for part in parts), encoding="utf-8")
    found = read_loops(path, normal_load="2")
    assert [loop.displacement_um.size for loop in found] == [128] * 4


def test_of_cycles_that_are_not_numbered_in_every_row_it_is_said_how_many_lack_a_number(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    numbered = rows(LOOPS[0], "1") + rows(LOOPS[1], "")
    path.write_text(f"Cycle,Displacement (um),Force (N)\n{numbered}", encoding="utf-8")
    with pytest.raises(RecordError, match=r"cycle is missing in 128 of 256 rows, but must be a whole number"):
        read_loops(path, normal_load="2")


@pytest.mark.parametrize("head", [[["Machine", 7], []], pytest.param([], marks=pytest.mark.slow)])
@pytest.mark.parametrize("titles", ["Cycle {}", "Zyklus_{}", "N={}"])
def test_sheets_of_a_workbook_are_read_as_their_cycles(tmp_path: Path, titles: str, head: list[list[object]]) -> None:
    names: list[list[object]] = [*head, ["Displacement", "Force"], ["um", "N"]]
    sheets: list[Titled] = [(titles.format(n), names, own) for n, own in zip(CYCLES, LOOPS, strict=True)]
    path = workbook(tmp_path / "log.xlsx", [*sheets, ("Summary", [["cycle", "energy"]], LOOPS[0])])
    require_right(path)
    assert any("4 sheets are read, as cycles 1, 100, 1000, 5000" in message for message in guess(path).remarks)
    assert any("'Summary' is not read" in message for message in guess(path).remarks)


def test_sheets_are_numbered_by_what_stands_above_their_names_and_by_tests(tmp_path: Path) -> None:
    names = ["Displacement (um)", "Force (N)"]
    pairs = [(1, 1), (1, 5000), (2, 1), (2, 5000)]
    sheets: list[Titled] = [
        (f"Test {repeat} {'ab'[cycle > 1]}", [[f"Cycle {cycle}"], names], own)
        for (repeat, cycle), own in zip(pairs, LOOPS, strict=True)
    ]
    path = workbook(tmp_path / "log.xlsx", sheets)
    require_right(path, [repeat for repeat, _ in pairs], [cycle for _, cycle in pairs])


def test_sheets_that_nothing_numbers_are_named_as_not_read(tmp_path: Path) -> None:
    names = [["Displacement (um)", "Force (N)"]]
    path = workbook(tmp_path / "log.xlsx", [(f"Sheet{n}", names, own) for n, own in enumerate(LOOPS)])
    message = "log.xlsx: of its sheets, 'Sheet1', 'Sheet2', 'Sheet3' are not read"
    assert message in guess(path).remarks
    (loop,) = read_loops(path)
    assert message in loop.notes


@pytest.mark.parametrize(("further", "left"), [("", "'Cycle 100', 'Summary' are"), (BLOCKS, "'Summary' is")])
def test_a_mapping_written_by_hand_names_the_sheets_that_its_import_does_not_read(
    tmp_path: Path, further: str, left: str
) -> None:
    own: list[Titled] = [(f"Cycle {n}", [["x_um", "Q_N"]], LOOPS[0]) for n in CYCLES[:2]]
    workbook(tmp_path / "log.xlsx", [*own, ("Summary", [["cycle", "energy"]], LOOPS[0])])
    loops = '\n[loops]\nfiles = "log.xlsx"\n[loops.columns]\ndisplacement_um = "x_um"\ntangential_force_N = "Q_N"\n'
    path = tmp_path / "mapping.toml"
    path.write_text(HEAD + loops.replace("\n[loops.", f"{further}\n[loops."), encoding="utf-8")
    if further:
        path.write_text(path.read_text(encoding="utf-8") + 'cycle = "cycle of block"\n', encoding="utf-8")
    record = import_record(path)
    assert len(record.loops) == (2 if further else 1)
    assert record.notes.count(f"log.xlsx: of its sheets, {left} not read") == 1


@pytest.mark.parametrize(
    ("labels", "message"),
    [
        (
            ("running-in", "steady", "steady", "end"),
            "the column 'Phase' holds words, such as 'running-in', 'steady', 'end'",
        ),
        (("3", "4", "7", "7"), "the column 'Phase' counts from 3 to 7"),
    ],
)
def test_a_column_that_parts_the_samples_and_is_not_read_is_named(
    tmp_path: Path, labels: tuple[str, ...], message: str
) -> None:
    path = tmp_path / "log.csv"
    parts = (rows(own, label) for label, own in zip(labels, LOOPS, strict=True))
    path.write_text("Phase,Displacement um,Force N\n" + "".join(parts), encoding="utf-8")
    assert any(f"{message}, and is not read" in note for note in guess(path).remarks)
    assert any(f"{message}, and is not read" in note for note in read_loops(path)[0].notes)


def test_a_formula_without_a_value_is_named_with_its_place(tmp_path: Path) -> None:
    path = workbook(tmp_path / "log.xlsx", [("Data", [["Displacement (um)", "Force (N)"]], LOOPS[0])])
    book = openpyxl.load_workbook(path)
    for row in range(2, 130):
        book["Data"].cell(row, 2, f"=0.5*A{row}")
    book.save(path)
    with pytest.raises(RecordError, match=r"line 2, column Force \(N\): '=\?' is no number, but a formula without a"):
        read_loops(path)


def repacked(path: Path, changes: dict[bytes, bytes]) -> Path:
    """The workbook with bytes of its first sheet replaced."""
    stream = io.BytesIO()
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            data = old.read(name)
            for one, other in changes.items() if name == "xl/worksheets/sheet1.xml" else ():
                data = data.replace(one, other)
            new.writestr(name, data)
    path.write_bytes(stream.getvalue())
    return path


FAR = b"".join(b'<row r="%d"><c r="XFD%d"><v>1</v></c></row>' % (n, n) for n in range(200, 30000))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({b'<row r="50"': b'<row r="99999999999"'}, "a row of number 99 999 999 999, where a sheet has at most 1 048"),
        ({b'r="B50"': b'r="XFE50"'}, "a column of number 16 385, where a sheet has at most 16 384"),
        ({b"</sheetData>": FAR + b"</sheetData>"}, "cells over more than 5"),
    ],
    ids=["row 10^11", "beyond XFD", "30 000 in XFD"],
)  # fmt: skip
def test_workbooks_are_weighed_before_they_are_read(tmp_path: Path, changes: dict[bytes, bytes], message: str) -> None:
    path = workbook(tmp_path / "log.xlsx", [("Data", [["Displacement (um)", "Force (N)"]], LOOPS[0])])
    repacked(path, changes)
    with pytest.raises(RecordError, match=message.replace(" ", r"\s")):
        read_loops(path)
