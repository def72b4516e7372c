"""The page and pictures of a comparison: nothing cut off on a phone, piles seen, and what one repeat cannot show."""

import dataclasses
import html
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Annotation

from tests.browser import TOO_WIDE, browser, needs_browser
from tests.synthetic_results import result
from wirewear import record_of_result
from wirewear.comparison.comparison import RecordComparison, compare
from wirewear.loops.sensor import Sensor, SensorNoise
from wirewear.pictures import style
from wirewear.records import AnyRecord
from wirewear.records.importing.preview import mark_motion
from wirewear.results import RunResult
from wirewear.test import load_study
from wirewear.views.comparison_page import ONE_REPEAT, differences_table, page, write_comparison
from wirewear.views.comparison_pictures import every_map

pytestmark = pytest.mark.seconds

STUDY = load_study(Path(__file__).parents[2] / "studies" / "steel_wires" / "study.toml")
NOISY = Sensor(noise=SensorNoise(displacement_um=0.15, tangential_force_N=0.008, normal_force_N=0.01))


@pytest.fixture(scope="module")
def run() -> RunResult:
    return dataclasses.replace(result("", 167.0), study=STUDY.variant("compliant").resolved())


def noisy(run: RunResult, repeats: int) -> AnyRecord:
    return record_of_result(run, sensor=NOISY, repeats=repeats, seed=3, samples=128)


@pytest.fixture(scope="module")
def alone(run: RunResult) -> RecordComparison:
    return compare(run, noisy(run, 1))


def test_of_one_repeat_a_page_says_that_nothing_is_judged_and_gives_per_cent(alone: RecordComparison) -> None:
    text = html.unescape(page(alone, []))
    assert ONE_REPEAT in text
    assert "difference / measured [%]" in text
    assert "difference / scatter" not in text
    headings = [column.header for column in differences_table(alone).columns]
    assert headings[-1] == "in per cent"
    row = next(one for one in alone.differences if one.quantity == "dissipated energy")
    assert row.percent == pytest.approx(100.0 * row.difference / (row.measured or np.nan))


@pytest.mark.slow
@needs_browser
def test_on_a_phone_no_map_and_no_column_of_a_comparison_lies_beyond_the_screen(run: RunResult, tmp_path: Path) -> None:
    path = write_comparison(compare(run, noisy(run, 2)), tmp_path)[0]
    with browser() as shown:
        shown.open(path, 390, 844, phone=True)
        assert shown.value(TOO_WIDE) == []
        hidden = "[...document.querySelectorAll('.scroll')].filter(e => e.scrollWidth > e.clientWidth + 1).length"
        assert shown.value(hidden) == 0
        assert shown.value("document.querySelectorAll('.maps svg').length") == 6
        widths = shown.value("[...document.querySelectorAll('.maps svg')].map(e => e.getBoundingClientRect().width)")
        assert min(widths) > 300


def test_what_is_piled_up_has_a_colour_of_its_own_and_a_place_on_the_scale(alone: RecordComparison) -> None:
    piled = [dataclasses.replace(pair, measured=pair.measured - 2.0) for pair in alone.scars]
    shown = every_map(piled)[0]
    assert shown.norm.vmin is not None
    assert shown.norm.vmin < -1.9
    colours, norm = style.depth_scale([np.array([-2.0, 0.0, 10.0])])
    raised, level, deep = (np.array(colours(norm(depth))[:3]) for depth in (-2.0, 0.0, 10.0))
    assert raised[1] > raised[0] + 0.2  # Green, which no depth has.
    assert np.abs(level - style.DEPTH_COLOURS(0.0)[:3]).max() < 0.02
    assert np.abs(deep - style.DEPTH_COLOURS(1.0)[:3]).max() < 0.02


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_first_loop_of_an_import_shows_where_its_force_must_be_positive(
    alone: RecordComparison, sign: float
) -> None:
    loop = alone.record.loops[0]
    axes = Figure().subplots()
    mark_motion(axes, dataclasses.replace(loop, tangential_force_N=sign * loop.tangential_force_N))
    (arrow, said) = axes.texts
    assert isinstance(arrow, Annotation)
    assert arrow.xy[0] > arrow.xyann[0]
    assert sign * arrow.xyann[1] > 0.0
    assert "Q must be positive" in said.get_text()
