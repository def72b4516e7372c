"""Numbers whose thousands are parted by signs: read as what they are, or refused with a question; never wrongly."""

import math
from pathlib import Path

import numpy as np
import pytest

from tests import strangers_files as strangers
from wirewear.base.delimited import DelimitedLayout, DelimitedText
from wirewear.base.errors import RecordError
from wirewear.loops.area import enclosed_area
from wirewear.views.loops_sources import read_loops


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
def test_signs_that_also_part_columns_are_refused_where_the_rows_differ(
    tmp_path: Path, delimiter: str, sign: str
) -> None:
    rows = log(delimiter, sign, ".").partition("\n")[2].encode()
    text = DelimitedText(tmp_path, rows, DelimitedLayout(delimiter.strip() or None, names_line=False))
    with pytest.raises(RecordError, match=r"line 2, column \d: there are \d fields where line 1 has \d"):
        text.numbers({"displacement": 1}, as_logged=True)


@pytest.mark.parametrize("sign", [".", ","])
def test_whole_numbers_whose_sign_may_be_the_decimal_sign_are_asked_about(tmp_path: Path, sign: str) -> None:
    rows = [(spelled(1e3 * x, 0, sign, "?"), "1") for x in strangers.X]
    path = tmp_path / "log.csv"
    path.write_text("Displacement (nm);Force (N)\n" + "\n".join(";".join(row) for row in rows), encoding="utf-8")
    with pytest.raises(RecordError, match=r"is a fraction or a number of thousands is not told"):
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
