"""The page of a run: all in one file, figures as the result has them, and a browser that shows and moves them."""

import base64
import dataclasses
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.browser import TOO_WIDE, Page, browser, needs_browser
from tests.studies import minimal
from tests.synthetic_results import earlier_line_result, result
from wirewear.results import RunResult, read_result
from wirewear.results.scar import health
from wirewear.views.run_maps import running_conditions
from wirewear.views.run_page import page_data, run_page, write_page

pytestmark = pytest.mark.seconds


def stated(run: RunResult, stiffness: float | str) -> RunResult:
    """The result with a whole study in it."""
    study = minimal() | {"holder": {"tangential_stiffness_N_per_mm": stiffness}}
    return dataclasses.replace(run, study=study)


@pytest.fixture(scope="module")
def runs() -> list[RunResult]:
    return [stated(result("compliant", 167.0), 167.0), stated(result("rigid"), "rigid")]


@pytest.fixture(scope="module")
def page_path(runs: list[RunResult], tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_page(runs, tmp_path_factory.mktemp("page"))


def test_a_page_needs_no_other_file_and_is_small(page_path: Path) -> None:
    text = page_path.read_text(encoding="utf-8")
    assert re.findall(r"(?:src|href)\s*=\s*[\"'](?!data:|#)[^\"']*", text) == []
    assert "@import" not in text
    assert "fetch(" not in text
    assert len(text) < 700_000


def test_what_is_drawn_is_what_was_computed(runs: list[RunResult]) -> None:
    shown = page_data(runs)["runs"][0]
    run = runs[0]
    assert shown["evolution"]["slip_amplitude_um"] == pytest.approx(run.evolution["slip_amplitude_um"], rel=1e-4)
    loop = shown["loops"][-1]
    assert max(loop["q"]) == pytest.approx(float(run.loop(100_000).tangential_force_N.max()), rel=1e-4)
    scar = shown["scars"]["fixed"]
    packed = np.frombuffer(base64.b64decode(scar["depths"][-1]), "<u2").reshape(2 * [len(scar["lines"])])
    depth = packed / 65535 * scar["deepest"]
    expected = run.scar(100_000, "fixed").sampled(np.array(scar["lines"]), np.array(scar["lines"]))
    assert np.abs(depth - expected).max() < 0.05 * scar["deepest"]
    assert depth.max() == pytest.approx(20.0, rel=0.01)
    assert scar["section"]["depths"][-1][80] == pytest.approx(20.0, rel=1e-3)
    # 1.5e-5 mm³/J for each wire.
    assert shown["slope_mm3_per_J"] == pytest.approx(3e-5, rel=1e-4)


def test_a_line_contact_has_the_same_page_per_mm_of_whatever_length(tmp_path: Path) -> None:
    (tmp_path / "line.h5").write_bytes(earlier_line_result())
    line = read_result(tmp_path / "line.h5")
    (run,), (longer,) = (page_data([one])["runs"] for one in (line, line.of_length(7.0)))
    assert longer == run
    assert run["units"] == {"force": "N/mm", "energy": "mJ/mm", "worked": "J/mm", "worn": "µm²"}
    assert run["courses"]["force"][-1] == pytest.approx(60.0, rel=1e-3)
    scars = [line.scar(200, body) for body in ("pad", "specimen")]
    assert run["courses"]["worn"][-1] == pytest.approx(sum(scar.area_um2 for scar in scars), rel=1e-3)
    assert max(run["scars"]["pad"]["section"]["depths"][-1]) == pytest.approx(scars[0].max_depth_um, rel=1e-3)
    assert max(run["scars"]["pad"]["profiles"]["pressure_MPa"][-1]) == pytest.approx(
        scars[0].pressure_MPa.max(), rel=1e-3
    )
    assert "all per mm of its length" in run_page([line])


def test_running_conditions_follow_mindlin_and_the_rig(runs: list[RunResult]) -> None:
    """By hand: K = 2709 N/mm at 2 N: the contact slides from 1.5 · 0.62 · 2 / 2709 mm on; the rig takes µP/K more."""
    compliant, rigid = (running_conditions(run.study) for run in runs)
    assert compliant is not None
    assert rigid is not None
    here = int(np.argmin(np.abs(compliant.normal_load_N - 2.0)))
    assert rigid.test_um[here] == pytest.approx(1e3 * 1.5 * 0.62 * 2.0 / 2709.0, rel=0.01)
    assert compliant.test_um[here] - compliant.contact_um[here] == pytest.approx(7.43, rel=0.01)
    # A Hertz contact's radius grows with the cube root of the load.
    growth = np.log(rigid.contact_um[-1] / rigid.contact_um[0]) / np.log(100.0)
    assert growth == pytest.approx(2.0 / 3.0, rel=1e-6)
    assert running_conditions({"name": "a line contact"}) is None


@pytest.mark.seconds
def test_a_quality_beyond_its_limit_is_bold(runs: list[RunResult]) -> None:
    bad = dataclasses.replace(runs[0], quality={"energy_against_loops": 0.3, "penetration": 1e-9, "of_its_own": 1.0})
    rows = {row.meaning: row.sound for row in health([bad])}
    assert rows == {
        "penetration of one body into the other, relative to the approach": True,
        "energy that wore against energy of the recorded loops, relative": False,
        "of its own": True,
    }
    assert run_page([bad]).count('class="beyond"') == 1


def test_texts_of_a_study_cannot_break_the_page(runs: list[RunResult]) -> None:
    name = "</script><b>bold</b>"
    text = run_page([dataclasses.replace(runs[0], name=name, variant=name)])
    assert "<b>bold" not in text
    data = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    assert data is not None
    assert json.loads(data[1])["runs"][0]["label"] == name


@pytest.fixture(scope="module")
def chromium() -> Iterator[Page]:
    with browser() as page:
        yield page


def curve(page: Page, kind: str) -> Any:
    return page.value(f"document.querySelector('#loop path.{kind}').getAttribute('d')")


@pytest.mark.slow
@needs_browser
def test_the_slider_moves_the_loop_and_the_scar(chromium: Page, page_path: Path) -> None:
    chromium.open(page_path)
    last, scar = curve(chromium, "now"), chromium.value("document.querySelector('#scar').dataset.deepest")
    assert float(scar) == pytest.approx(20.0, rel=0.01)
    chromium.value("(s => { s.value = 1; s.dispatchEvent(new Event('input')); })(document.querySelector('#cycle'))")
    chromium.settle()
    assert curve(chromium, "now") != last
    assert float(chromium.value("document.querySelector('#scar').dataset.deepest")) == pytest.approx(
        20.0 * 0.0316, rel=0.05
    )
    assert chromium.value("document.querySelector('#at').textContent") == "100 of 100\u2009000"
    numbers = chromium.value("[...document.querySelectorAll('#ratio svg text')].map(t => t.textContent)")
    assert {"1", "10", "100\u2009000"} <= set(numbers)
    assert chromium.value("document.querySelectorAll('#response path.tension').length") > 1
    assert chromium.problems == []


@pytest.mark.slow
@needs_browser
def test_on_a_phone_nothing_is_wider_than_the_screen(chromium: Page, page_path: Path) -> None:
    chromium.open(page_path, 390, 844, phone=True)
    assert chromium.value("[document.documentElement.scrollWidth, innerWidth]") == [390, 390]
    assert chromium.value(TOO_WIDE) == []
    assert chromium.problems == []
