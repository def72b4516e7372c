"""Files as laboratories have them, turned into records by a mapping."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.synthetic_loops import Recipe, SyntheticLoop
from wirewear import RecordError, check_record
from wirewear.records.importing import import_record

HEAD = """
format = 1
name = "test 3"
[wires]
diameter_mm = 0.45
youngs_modulus_MPa = 210000.0
poissons_ratio = 0.3
[conditions]
normal_load_N = 2.0
displacement_amplitude_um = 60.0
frequency_Hz = 4.0
cycles = 1000
"""

SAMPLES, FREQUENCY_Hz = 128, 4.0


@pytest.fixture(scope="module")
def cycle() -> tuple[Any, Any, Any]:
    """Time [s], displacement [µm] and force [N] of one cycle."""
    time, displacement, force = SyntheticLoop(Recipe()).sampled(SAMPLES)
    return time / FREQUENCY_Hz, displacement, force


def mapped(folder: Path, loops: str) -> Path:
    path = folder / "mapping.toml"
    path.write_text(HEAD + loops, encoding="utf-8")
    return path


def german(time: Any, displacement: Any, force: Any) -> str:
    """A logger's file: header, units, semicolons, decimal commas, mm and mN, the force's sign reversed."""
    rows = [
        f"{t:.6f};{1e-3 * x:.7f};{-1e3 * q:.4f}".replace(".", ",")
        for t, x, q in zip(time, displacement, force, strict=True)
    ]
    return "\r\n".join(["Prüfstand 2", "a", "b", "c", "d", "Zeit;Weg;Kraft", "s;mm;mN", *rows, ""])


GERMAN = """
[loops]
files = "cycle_*.txt"
name_pattern = 'cycle_(?P<cycle>\\d+)_rep(?P<repeat>\\d+)'
encoding = "latin-1"
delimiter = "semicolon"
decimal = ","
header_lines = 5
lines_after_names = 1
[loops.columns]
time_s = "Zeit"
displacement_um = { column = "Weg", unit = "mm" }
tangential_force_N = { column = "Kraft", unit = "mN", factor = -1.0 }
"""


def test_one_file_a_cycle_with_decimal_commas_other_units_and_encoding(tmp_path: Path, cycle: Any) -> None:
    for number in (2, 10, 100):
        for repeat in (1, 2):
            (tmp_path / f"cycle_{number}_rep{repeat}.txt").write_bytes(german(*cycle).encode("latin-1"))
    record = import_record(mapped(tmp_path, GERMAN))
    assert record.repeats == (1, 2)
    assert record.cycles == (2, 10, 100)
    loop = record.loop(2, 10)
    np.testing.assert_allclose(loop.displacement_um, cycle[1], atol=1e-4)
    np.testing.assert_allclose(loop.tangential_force_N, cycle[2], atol=1e-6)
    assert loop.normal_force_N is None
    assert not check_record(record).problems


def test_a_continuous_log_is_cut_into_cycles_by_the_frequency_and_the_cut_off_rest_is_left_out(
    tmp_path: Path, cycle: Any
) -> None:
    _, displacement, force = cycle
    x, q = np.tile(displacement, 4)[:-40], np.tile(force, 4)[:-40]
    rows = "\n".join(f"{a:.5f}\t{b:.6f}\t0.5" for a, b in zip(x, q, strict=True))
    (tmp_path / "log.tsv").write_text(rows, encoding="utf-8")
    loops = f"""
[loops]
files = "log.tsv"
delimiter = "tab"
names_line = false
sample_rate_Hz = {SAMPLES * FREQUENCY_Hz}
first_cycle = 51
[loops.columns]
displacement_um = 1
tangential_force_N = 2
normal_force_N = {{ column = 3, unit = "V", factor = 4.0 }}
"""
    record = import_record(mapped(tmp_path, loops))
    assert record.cycles == (51, 52, 53)
    assert {loop.time_s.size for loop in record.loops} == {SAMPLES}
    last = record.loop(1, 53)
    np.testing.assert_allclose(last.displacement_um, displacement, atol=1e-4)
    assert last.normal_force_N is not None
    np.testing.assert_allclose(last.normal_force_N, 2.0)
    assert last.time_s[0] == 0.0


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"Weg"', '"Hub"', r"cycle_1_rep1.txt, line 6: there is no column 'Hub' among 'Zeit, Weg, Kraft'"),
        ('"Weg"', '"weg"', r"there is no column 'weg' among 'Zeit, Weg, Kraft'; did you mean 'Weg'\?"),
        ('unit = "mN"', 'unit = "MN"', r"tangential_force_N cannot be in 'MN': the units known there are N, mN, kN"),
        ('unit = "mN", factor = -1.0', 'unit = "V"', r"needs a factor in N per volt"),
        ('decimal = ","', 'decimal = "."', r'line 8, column Weg: .* is no number, or decimal = "," is meant'),
        ("header_lines = 5", "header_lines = 500", r"line 503: there are no numbers below the header"),
        ('"cycle_*.txt"', '"loop_*.txt"', r"there is no file .*loop_\*\.txt"),
        ("_rep(?P<repeat>", "-rep(?P<repeat>", r"does not fit name_pattern"),
        ("name_pattern", "# name_pattern", None),
        ('"latin-1"', '"utf-8"', r"cycle_1_rep1.txt, line \d: this is not text in UTF-8"),
        ('"latin-1"', '"klingon"', r"must be an encoding of text such as"),
        ('"semicolon"', '"pipe"', r'must be one of "comma", "semicolon", "tab", "whitespace", or the sign itself'),
        ("tangential_force_N =", "tangential_force_mN =", r"tangential_force_N"),
        ("[loops.columns]", "[loops.column]", r"line \d+"),
    ],
)  # fmt: skip
def test_mistakes_in_a_mapping_are_one_sentence(
    tmp_path: Path, cycle: Any, old: str, new: str, words: str | None
) -> None:
    (tmp_path / "cycle_1_rep1.txt").write_bytes(german(*cycle).encode("latin-1"))
    assert old in GERMAN
    path = mapped(tmp_path, GERMAN.replace(old, new))
    if words is None:
        # Without a pattern the file is cut by its time.
        assert import_record(path).cycles == (1,)
        return
    with pytest.raises(RecordError, match=words) as caught:
        import_record(path)
    assert "\n" not in str(caught.value)
