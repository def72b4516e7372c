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
from click.testing import CliRunner

from tests.browser import TOO_WIDE, Page, browser, needs_browser
from tests.studies import minimal
from tests.synthetic_results import LOAD_N, AMPLITUDE_um, result
from wirewear.base.errors import ResultError
from wirewear.faces import cli
from wirewear.results import Evolution, RunResult, write_result
from wirewear.results.quality import health
from wirewear.views.run_data import page_data, slope_mm3_per_J
from wirewear.views.run_maps import energy_ratio, running_conditions
from wirewear.views.run_page import run_page, write_page
from wirewear.views.run_wording import regime, sentence


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


def test_the_page_names_the_length_of_mean_pressures_and_nodes_of_older_results(runs: list[RunResult]) -> None:
    older = dataclasses.replace(runs[1], settings={})
    new, old = (run["pressures"] for run in page_data([runs[0], older])["runs"])
    assert [words for _, words, _ in new] == ["largest mean over 28.6 µm", "mean over 28.6 µm at mid-stroke"]
    assert [name for name, _, _ in old] == ["max_pressure_MPa", "mid_stroke_pressure_MPa"]


def test_the_slope_is_that_of_a_line_through_the_origin() -> None:
    energy = np.array([0.0, 1.0, 2.0])
    assert slope_mm3_per_J(energy, 3e-5 * energy) == pytest.approx(3e-5)
    assert np.isnan(slope_mm3_per_J(np.zeros(2), np.zeros(2)))


def test_the_sentence_says_what_came_out(runs: list[RunResult]) -> None:
    text = sentence(runs[0])
    assert text.startswith("compliant: after 100\u2009000 cycles the surfaces slip ±49.6 µm of the ±60 µm imposed")
    assert "20 µm deep in the fixed wire, 12 µm in the moving wire." in text
    failed = dataclasses.replace(runs[0], status="failed", message="the contact left the fine patch")
    assert sentence(failed).endswith("The run is failed: the contact left the fine patch.")


def test_loops_are_judged_by_their_energy_ratio(runs: list[RunResult]) -> None:
    full = np.array([4e-3 * AMPLITUDE_um * LOAD_N])
    assert energy_ratio(full, np.array([AMPLITUDE_um]), np.array([LOAD_N])) == pytest.approx(1.0)
    assert regime(runs[0]) == "gross slip throughout"
    columns = dict(runs[0].evolution)
    both = ("dissipated_energy_mJ", "slip_amplitude_um")
    thin = columns | {name: columns[name] * np.linspace(0.05, 1.0, columns["cycle"].size) for name in both}
    assert "mixed" in regime(dataclasses.replace(runs[0], evolution=Evolution(thin)))
    none = columns | {name: 0.01 * columns[name] for name in both}
    assert regime(dataclasses.replace(runs[0], evolution=Evolution(none))) == "partial slip throughout"
    # Slopes of a worn scar carry more force than little friction does: the loop is as wide as the bodies slide.
    steep = columns | {"dissipated_energy_mJ": 0.01 * columns["dissipated_energy_mJ"]}
    assert regime(dataclasses.replace(runs[0], evolution=Evolution(steep))) == "gross slip throughout"


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


def test_a_run_without_scars_or_wear_has_a_page(runs: list[RunResult]) -> None:
    bare = dataclasses.replace(runs[0], scars=(), loops=(), status="running", message="stopped early")
    assert "stopped early" in run_page([bare])


def test_the_command_writes_the_page_beside_the_result(runs: list[RunResult], tmp_path: Path) -> None:
    for run in runs:
        write_result(tmp_path / run.variant / "result.h5", run)
    told = CliRunner().invoke(cli, ["report", str(tmp_path)])
    assert (told.exit_code, told.output.strip()) == (0, str(tmp_path / "report.html"))
    told = CliRunner().invoke(cli, ["report", str(tmp_path / "rigid" / "result.h5")])
    assert (tmp_path / "rigid" / "report.html").exists()
    empty = dataclasses.replace(runs[0], evolution=Evolution.from_rows([]))
    with pytest.raises(ResultError, match="nothing is measured yet"):
        write_page([empty], tmp_path)


@pytest.fixture(scope="module")
def chromium() -> Iterator[Page]:
    with browser() as page:
        yield page


#: Share of the canvas that is drawn on, number of colours, and a number that changes with the picture.
INKED = """(canvas => {
    const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data, seen = new Set();
    let count = 0, sum = 0;
    for (let i = 0; i < pixels.length; i += 4) if (pixels[i + 3] > 250) {
        count++;
        seen.add(pixels.slice(i, i + 3).join());
        sum = (sum * 31 + pixels[i] + i) % 1e9;
    }
    return [4 * count / pixels.length, seen.size, sum];
})(document.querySelector("#scar"))"""


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
def test_the_scar_is_drawn_and_turned_by_dragging(chromium: Page, page_path: Path) -> None:
    chromium.open(page_path)
    share, colours, before = chromium.value(INKED)
    assert share > 0.15
    assert colours > 200
    chromium.drag("#scar", (100.0, 0.0))
    assert float(chromium.value("document.querySelector('#scar').dataset.azimuth")) == pytest.approx(
        -62.0 - 40.0, abs=1.0
    )
    assert chromium.value(INKED)[2] != before
    assert chromium.problems == []


@pytest.mark.slow
@needs_browser
def test_on_a_phone_nothing_is_wider_than_the_screen(chromium: Page, page_path: Path) -> None:
    chromium.open(page_path, 390, 844, phone=True)
    assert chromium.value("[document.documentElement.scrollWidth, innerWidth]") == [390, 390]
    assert chromium.value(TOO_WIDE) == []
    assert chromium.problems == []


@pytest.mark.slow
@needs_browser
def test_tables_are_offered_as_csv(chromium: Page, page_path: Path) -> None:
    chromium.open(page_path)
    chromium.value("window.saved = []; URL.createObjectURL = b => { saved.push(b); return 'data:,'; }")
    chromium.value("document.querySelectorAll('[data-table]').forEach(b => b.click())")
    texts = chromium.value("Promise.all(saved.map(b => b.text()))")
    heads = [text.split("\n", 1)[0] for text in texts]
    assert heads[1] == "run,cycle,displacement_um,tangential_force_N"
    assert heads[0].startswith("run,cycle,displacement_amplitude_um,slip_amplitude_um")
    assert all(len({line.count(",") for line in text.strip().split("\n")}) == 1 for text in texts)
    assert chromium.problems == []
