"""Files of fifty kinds and lines of styluses, in two languages each, guessed or asked for; none is read wrongly."""

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.records import strangers_files as strangers
from tests.records import strangers_profiles
from tests.records.loop_files import STEEL
from tests.records.strangers_files import CHINESE, ENGLISH, FRENCH, GERMAN, SPANISH, Language, Written, energy_mJ, write
from tests.records.strangers_loggers import LOGGERS
from tests.records.strangers_maps import MAPS, DEPTH_um, volume_mm3
from wirewear.base.delimited import DelimitedLayout, DelimitedText
from wirewear.base.errors import RecordError
from wirewear.loops.sensor import enclosed_area
from wirewear.records.importing import guessing, import_record
from wirewear.records.importing.guessed_scars import Touching
from wirewear.records.importing.loop_sources import read_loops
from wirewear.records.importing.text_reader import open_lines
from wirewear.records.values import ExperimentRecord

KINDS = strangers.KINDS | LOGGERS | MAPS
#: Kinds in which the other language is neither English nor German.
OTHERS = {
    "blank line before numbers": SPANISH, "no time and no cycle": FRENCH, "xlsx": SPANISH, "column of words": FRENCH,
    "units written out": FRENCH, "own signs in UTF-8": CHINESE, "own signs in GBK": CHINESE,
}  # fmt: skip
#: Columns of displacement and force as the command takes them; None is to be recognised.
LOGGED: dict[str, tuple[str | None, str | None]] = {
    "xlsx": (None, None), "TDMS": (None, None), "LVM, one time": (None, None), "UMT export": (None, None),
    "MATLAB vectors": ("Displacement:mm", "Friction_force:N"),
    "MATLAB channels as rows": ("hyst(1,:):mm", "hyst(2,:):N"), "two columns without names": ("2:cm", "1:N"),
    "clock with a date": (None, None), "names with blanks": (None, None), "steps of a programme": (None, None),
}  # fmt: skip


def spelled(value: float, digits: int, sign: str, decimal: str) -> str:
    """A number with a sign between its thousands."""
    return f"{value:,.{digits}f}".translate({ord(","): sign, ord("."): decimal})


def log(delimiter: str, sign: str, decimal: str, digits: int = 1, *, quoted: bool = False) -> str:
    """Loops in nm and mN over a time in s."""
    rows = [["Time (s)", "Displacement (nm)", "Force (mN)"]]
    for time, x, force in zip(strangers.TIME, strangers.X, strangers.FORCE, strict=True):
        numbers = (time, 5), (1e3 * x, digits), (1e3 * force, digits)
        rows.append([spelled(value, places, sign, decimal) for value, places in numbers])
    return "\n".join(delimiter.join(f'"{one}"' if quoted else one for one in row) for row in rows) + "\n"


@pytest.mark.parametrize(
    ("delimiter", "sign", "decimal", "quoted"),
    [
        (",", ",", ".", True),
        (",", ".", ",", True),
        ("\t", ",", ".", False),
        ("   ", ",", ".", False),
        (";", ".", ",", False),
        (";", " ", ",", False),
        (";", "\u202f", ",", False),
        (",", "'", ".", False),
        (",", "’", ".", False),
    ],
)
@pytest.mark.parametrize("digits", [0, 1])
def test_signs_between_thousands_change_no_number(
    tmp_path: Path, delimiter: str, sign: str, decimal: str, quoted: bool, digits: int
) -> None:
    """The energy is that of the closed form."""
    path = tmp_path / "log.csv"
    path.write_text(log(delimiter, sign, decimal, digits, quoted=quoted), encoding="utf-8")
    for loop in read_loops(path):
        energy = 1e-3 * enclosed_area(loop.displacement_um, loop.tangential_force_N)
        assert energy == pytest.approx(strangers.energy_mJ(), rel=0.01)


@pytest.mark.parametrize(("delimiter", "sign"), [(",", ","), ("   ", " ")])
def test_signs_that_also_part_columns_are_refused_where_rows_differ(tmp_path: Path, delimiter: str, sign: str) -> None:
    rows = log(delimiter, sign, ".").partition("\n")[2].encode()
    text = DelimitedText(tmp_path, rows, DelimitedLayout(delimiter.strip() or None, names_line=False))
    with pytest.raises(RecordError, match=r"line 2, column \d: there are \d fields where line 1 has \d"):
        text.numbers({"displacement": 1}, as_logged=True)


@pytest.mark.parametrize("sign", [".", ","])
def test_whole_numbers_whose_sign_may_be_the_decimal_sign_are_asked_about(tmp_path: Path, sign: str) -> None:
    rows = [(spelled(1e3 * x, 0, sign, "?"), "1") for x in strangers.X]
    path = tmp_path / "log.csv"
    path.write_text("Displacement (nm);Force (N)\n" + "\n".join(";".join(row) for row in rows), encoding="utf-8")
    with pytest.raises(RecordError, match=r"is a fraction or a number of thousands is uncertain"):
        read_loops(path)


@pytest.mark.parametrize("decimal", [".", ","])
def test_fractions_of_three_digits_stay_fractions(tmp_path: Path, decimal: str) -> None:
    rows = np.array([[0.25, 1.234], [1.5, 12.345], [2.0, math.nan]])
    lines = (";".join("" if np.isnan(one) else f"{one:.3f}".replace(".", decimal) for one in row) for row in rows)
    text = DelimitedText(tmp_path, "\n".join(["t;x", *lines]).encode(), DelimitedLayout(";", decimal))
    for as_logged in (False, True):
        np.testing.assert_array_equal(text.numbers({"x": 1}, as_logged=as_logged).columns["x"], rows[:, 1])


def test_a_point_in_numbers_with_decimal_commas_is_no_second_decimal_sign(tmp_path: Path) -> None:
    shown = DelimitedText(tmp_path, b"t;x\n0,25;1.234\n", DelimitedLayout(";", ","))
    np.testing.assert_array_equal(shown.numbers({"x": 1}).columns["x"], [1234.0])
    doubtful = DelimitedText(tmp_path, b"t;x\n1;1.234\n", DelimitedLayout(";", ","))
    with pytest.raises(RecordError, match=r"line 2, column x: '1.234' is no number, or decimal = \".\" is meant"):
        doubtful.numbers({"x": 1})


def filled_in(text: str, answers: dict[str, str]) -> str:
    """The mapping with what it leaves open answered, as its user would."""
    lines = text.splitlines()
    for number, key in open_lines(text):
        # What was recognised stays: only unit or factor are asked for.
        answer = answers.get(key)
        if answer is None:
            unit = {"displacement_um": "mm", "tangential_force_N": "N"}[key]
            lines[number - 1] = lines[number - 1].replace('unit = "?"', f'unit = "{unit}"')
        else:
            lines[number - 1] = f"{key} = {answer}"
    return "\n".join(lines) + "\n"


def guessed(files: Sequence[Path], known: dict[str, Any]) -> guessing.GuessedMapping:
    """The mapping for tests of steel wires."""
    return guessing.guessed_mapping(files, known, Touching.of("crossed-wires", known, STEEL, {}))


def imported(written: Written, folder: Path) -> ExperimentRecord:
    """What guess, answers and import make of the files."""
    text = guessing.mapping_text(guessed(write(written, folder), {"diameter_mm": 0.45} | dict(written.known)))
    mapping = folder / "mapping.toml"
    mapping.write_text(text, encoding="utf-8")
    if left := open_lines(text):
        with pytest.raises(RecordError, match=rf"not filled in: .*line {left[0][0]} \({left[0][1]}\)"):
            import_record(mapping)
        mapping.write_text(filled_in(text, dict(written.answers)), encoding="utf-8")
    assert bool(left) == bool(written.answers), text
    return import_record(mapping)


@pytest.mark.seconds
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    "foreign", [pytest.param(False, id="English"), pytest.param(True, id="foreign", marks=pytest.mark.slow)]
)
def test_a_strangers_file_ends_in_the_right_values(tmp_path: Path, kind: str, foreign: bool) -> None:
    language: Language = OTHERS.get(kind, GERMAN) if foreign else ENGLISH
    written = KINDS[kind](language)
    record = imported(written, tmp_path)
    assert [loop.cycle for loop in record.loops] == [1, 2, 3, 4]
    assert record.tables.conditions.cycles == 4
    assert record.tables.conditions.frequency_Hz == pytest.approx(strangers.FREQUENCY_Hz, rel=0.002)
    assert record.tables.conditions.normal_load_N == pytest.approx(strangers.LOAD_N, rel=0.005)
    for loop, amplitude in zip(record.loops, written.amplitudes_um, strict=True):
        assert loop.time_s.size == pytest.approx(strangers.SAMPLES, abs=1)
        assert np.ptp(loop.displacement_um) == pytest.approx(2.0 * amplitude, rel=0.01)
        energy = 1e-3 * enclosed_area(loop.displacement_um, loop.tangential_force_N)
        # The first loop of growing amplitudes does not close.
        assert energy == pytest.approx(energy_mJ(amplitude), rel=0.01 if amplitude == strangers.AMPLITUDE_um else 0.2)
        if loop.normal_force_N is not None:
            assert loop.normal_force_N == pytest.approx(strangers.LOAD_N, rel=0.005)
    assert bool(record.scars) == written.scars
    for scar in record.scars:
        assert scar.body == "fixed"
        assert scar.volume_mm3 == pytest.approx(volume_mm3(), rel=0.01)
        assert np.nanmax(scar.depth_um) == pytest.approx(DEPTH_um, rel=0.01)
    assert bool(record.evolution) == written.evolution
    for table in record.evolution:
        np.testing.assert_array_equal(table.columns["cycle"], [1, 2, 4])
        np.testing.assert_array_equal(table.columns["dissipated_energy_mJ"], [0.2607, 0.2620, 0.2640])
        np.testing.assert_array_equal(table.columns["max_tangential_force_N"], [1.24, 1.25, 1.26])


@pytest.mark.seconds
@pytest.mark.parametrize("kind", LOGGED)
def test_the_command_loops_reads_the_same_files(tmp_path: Path, kind: str) -> None:
    (path,) = write(KINDS[kind](ENGLISH), tmp_path)
    displacement, force = LOGGED[kind]
    loops = read_loops(path, normal_load="2.0", displacement=displacement, force=force)
    joined = [np.concatenate([loop.displacement_um for loop in loops])]
    joined.append(np.concatenate([loop.tangential_force_N for loop in loops]))
    area = 1e-3 * enclosed_area(*joined)
    assert area == pytest.approx(4.0 * energy_mJ(), rel=0.01)


def test_one_file_that_cannot_be_read_does_not_keep_the_others_from_being_guessed(tmp_path: Path) -> None:
    files = write(KINDS["units in brackets"](ENGLISH), tmp_path)
    (tmp_path / "notes.txt").write_text("no table\nof numbers\n", encoding="utf-8")
    (tmp_path / "old.xls").write_bytes(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(600))
    (tmp_path / "cut.sur").write_bytes(b"DIGITAL SURF" + bytes(30))
    others = [tmp_path / name for name in ("notes.txt", "old.xls", "cut.sur")]
    remarks = " ".join(guessed([*files, *others], {"diameter_mm": 0.45}).remarks)
    assert re.search(r"notes.txt was left out: .*no table of numbers", remarks)
    assert "old.xls was left out" in remarks
    assert "cut.sur was left out" in remarks
    assert "save it as .xlsx or as CSV" in remarks


@pytest.mark.parametrize(
    ("names", "left"),
    [
        (("fixed_before", "fixed_after"), "fixed_before"),
        (("Fixed apres essai", "Fixed avant essai"), "Fixed avant essai"),
        (("fixed", "FixedNeu"), "FixedNeu"),
        (("fixed_new",), ""),
        (("fixed_after_minus_before",), ""),
        (("fixed_1", "fixed_2"), ""),
    ],
)
def test_a_map_from_before_the_test_is_no_scar_and_scars_without_loops_are_said(
    tmp_path: Path, names: Sequence[str], left: str
) -> None:
    maps = [tmp_path / f"{name}.csv" for name in names]
    for path in maps:
        rows = (f"{10 * (place % 12)},{10 * (place // 12)},0" for place in range(144))
        path.write_text("\n".join(("x_um,y_um,depth_um", *rows)), encoding="utf-8")
    guess = guessed([*write(KINDS["units in brackets"](ENGLISH), tmp_path), *maps], {"diameter_mm": 0.45})
    kept = sorted(f"{name}.csv" for name in names if name != left)
    assert guess.tables["scars"]["fixed"]["files"] == (kept if len(kept) > 1 else kept[0])
    remarks = " ".join(guess.remarks)
    assert (f"{left}.csv was left out" in remarks) == bool(left)
    assert ("the fixed wire has 2 scars" in remarks) == (len(kept) > 1)


def test_a_profile_along_a_line_is_no_map_of_a_scar(tmp_path: Path) -> None:
    (tmp_path / "profil.csv").write_text("Position [mm];Profiltiefe [µm]\n" + "0,5;1,0\n" * 20, encoding="utf-8")
    files = [*write(KINDS["units in brackets"](ENGLISH), tmp_path), tmp_path / "profil.csv"]
    assert "profil.csv was left out: it is a profile along a line" in " ".join(guessed(files, {}).remarks)


def test_what_is_assumed_of_the_wires_is_said(tmp_path: Path) -> None:
    files = write(KINDS["units in brackets"](ENGLISH), tmp_path)
    remarks = " ".join(guessed(files, {"diameter_mm": 0.45}).remarks)
    assert "taken for wires that cross at 90°; --kind" in remarks
    crossed = guessed(files, {"diameter_mm": 0.45, "crossing_angle_deg": 60.0})
    assert crossed.tables["wires"]["crossing_angle_deg"] == 60.0
    assert "90°" not in " ".join(crossed.remarks)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_force_of_a_contact_that_sticks_keeps_its_sign_if_it_rises_with_motion(tmp_path: Path, sign: float) -> None:
    """A spring: Q = K δ, with a lag that no logger resolves and noise."""
    noise = 0.002 * np.random.default_rng(1).standard_normal(strangers.X.size)
    force = sign * (0.01 * strangers.X) + noise
    head = "Time (s),Displacement (um),Force (N)\n"
    files = write(strangers.plain(head, (strangers.TIME, strangers.X, force), ENGLISH), tmp_path)
    guess = guessed(files, {"diameter_mm": 0.45, "normal_load_N": 2.0})
    assert guess.tables["loops"]["columns"]["tangential_force_N"].get("factor", 1.0) == sign


OF_STEEL = {"material": "steel"}
KNOWN = {
    "length_mm": 10.0, "radius_mm": 6.0, "normal_load_N": 20.0, "displacement_amplitude_um": 60.0, "frequency_Hz": 3.0,
    "cycles": 100,
}  # fmt: skip


@pytest.mark.parametrize("kind", strangers_profiles.PROFILES)
@pytest.mark.parametrize("foreign", [False, True], ids=["English", "foreign"])
def test_a_strangers_line_ends_in_the_right_profile(tmp_path: Path, kind: str, foreign: bool) -> None:
    language = (SPANISH if "alone" in kind or kind == "depths" else GERMAN) if foreign else ENGLISH
    written = strangers_profiles.PROFILES[kind](language)
    (tmp_path / "specimen.csv").write_text(written.text, encoding="utf-8")
    text = guessing.mapping_text(
        guessing.guessed_mapping(
            [tmp_path / "specimen.csv"], KNOWN, Touching.of("line-contact", KNOWN, OF_STEEL, OF_STEEL)
        )
    )
    mapping = tmp_path / "mapping.toml"
    assert {key for _, key in open_lines(text)} == written.answers.keys()
    mapping.write_text(filled_in(text, written.answers), encoding="utf-8")
    (profile,) = import_record(mapping).scars
    assert profile.x_um.size == strangers_profiles.POINTS
    assert profile.area_um2 == pytest.approx(strangers_profiles.AREA_um2, rel=0.01)
    assert profile.smooth_um.max() == pytest.approx(strangers_profiles.DEPTH_um, rel=0.01)
