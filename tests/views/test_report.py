"""The page of a run: all in one file, figures as the result has them, and a browser that shows and moves them."""

import base64
import dataclasses
import html
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import binom, t

from tests.browser import TOO_WIDE, Page, browser, needs_browser
from tests.commands import wirewear
from tests.studies import minimal
from tests.synthetic_results import bowl, earlier_line_result, result
from wirewear import check_record, read_record, record_of_result, write_record, write_result
from wirewear.comparison.comparison import compare
from wirewear.comparison.maps import running_conditions
from wirewear.comparison.registration import register
from wirewear.loops.sensor import Sensor, SensorNoise
from wirewear.records import MeasuredScar
from wirewear.results import Evolution, RunResult, read_result
from wirewear.results.health import health
from wirewear.test import load_study
from wirewear.views.run_page import page_data, run_page, write_page
from wirewear.views.run_words import length, sentence

pytestmark = pytest.mark.seconds


def stated(run: RunResult, stiffness: float | str) -> RunResult:
    """The result with a whole study in it."""
    return dataclasses.replace(run, study=minimal() | {"holder": {"tangential_stiffness_N_per_mm": stiffness}})


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


def drawn(runs: list[RunResult]) -> Any:
    """What a page draws, as its script reads it."""
    return json.loads(json.dumps(page_data(runs)))


def test_what_is_drawn_is_what_was_computed(runs: list[RunResult]) -> None:
    shown = drawn(runs)["runs"][0]
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
    (run,), (longer,) = (drawn([one])["runs"] for one in (line, line.of_length(7.0)))
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
@pytest.mark.parametrize("factor", [1e-300, 5e-324, 0.0])
def test_a_run_of_next_to_no_friction_has_a_page(runs: list[RunResult], factor: float) -> None:
    run, tables = runs[0], minimal() | {"contact": {"friction": factor}}
    scaled = ("max_tangential_force_N", "dissipated_energy_mJ", "accumulated_energy_J")
    columns = {name: column * (factor if name in scaled else 1.0) for name, column in run.evolution.items()}
    loops = tuple(dataclasses.replace(one, tangential_force_N=factor * one.tangential_force_N) for one in run.loops)
    faint = dataclasses.replace(run, study=tables, evolution=Evolution(columns), loops=loops)
    assert "<html" in run_page([faint])
    known, found = (drawn([one])["runs"][0]["slope_mm3_per_J"] for one in (run, faint))
    assert found == (pytest.approx(known / factor) if factor > 1e-310 else None)


def test_a_stroke_longer_than_a_body_is_said_to_be_no_fretting() -> None:
    plain = result()
    thin = dataclasses.replace(plain, scars=tuple(dataclasses.replace(scar, diameter_mm=0.11) for scar in plain.scars))
    assert "this is no fretting: ±60 µm is more than the radius of a body, 55 µm" in sentence(thin)
    assert "no fretting" not in sentence(plain)
    assert (length(999.4), length(3176.0)) == ("999 µm", "3.18 mm")


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
def test_runs_of_one_load_and_stroke_are_both_seen_on_the_maps(chromium: Page, page_path: Path) -> None:
    chromium.open(page_path)
    for place in ("conditions", "response"):
        circles = chromium.value(f"[...document.querySelectorAll('#{place} g circle')].map(c => c.getAttribute('r'))")
        first, second = map(float, circles)
        assert first > second + 2.0


@pytest.mark.slow
@needs_browser
def test_on_a_phone_nothing_is_wider_than_the_screen(chromium: Page, page_path: Path) -> None:
    chromium.open(page_path, 390, 844, phone=True)
    assert chromium.value("[document.documentElement.scrollWidth, innerWidth]") == [390, 390]
    assert chromium.value(TOO_WIDE) == []
    assert chromium.problems == []


ROOT = Path(__file__).parents[2]
STUDY = load_study(ROOT / "studies" / "steel_wires" / "study.toml")
NOISY = Sensor(noise=SensorNoise(displacement_um=0.15, tangential_force_N=0.008, normal_force_N=0.01))


@pytest.fixture(scope="module")
def run() -> RunResult:
    return dataclasses.replace(result("", 167.0), study=STUDY.variant("compliant").resolved())


def test_a_simulation_exported_and_compared_with_itself_differs_by_round_off(run: RunResult, tmp_path: Path) -> None:
    record = read_record(write_record(tmp_path, record_of_result(run)))
    assert not check_record(record).problems
    comparison = compare(run, record)
    assert len(comparison.loops) == len(run.loops)
    assert {row.source for row in comparison.differences} == {
        "loops", "evolution", "scar, moving wire", "scar, fixed wire",
    }  # fmt: skip
    for row in comparison.differences:
        assert abs(row.difference) <= 1e-9 * max(abs(row.simulated or 0.0), 1.0), row
        assert row.in_scatter == 0.0
    for pair in comparison.scars:
        (registration,) = pair.registrations
        assert abs(registration.shift_x_um) + abs(registration.shift_y_um) < 1e-6
        assert abs(registration.rotation_deg) < 1e-6


@pytest.mark.slow
def test_with_noise_a_simulation_differs_from_itself_as_students_t_has_it(run: RunResult) -> None:
    """The mean of 4 repeats over their scatter, times √4, follows Student's t with 3 degrees of freedom.

    Of slip amplitudes and stiffnesses, which noise does not bias; half of the ratios lie within the quartiles of t, and
    one in twenty beyond its 95 % limit, as far as counting can show. A scatter wrong by a factor of two would show.
    """
    ratios = []
    for seed in range(10):
        record = record_of_result(run, sensor=NOISY, repeats=4, seed=seed, samples=256)
        rows = compare(run, dataclasses.replace(record, scars=(), evolution=())).differences
        wanted = [row for row in rows if row.quantity in ("slip amplitude δ0", "measured stiffness")]
        assert {row.basis for row in wanted} == {"repeats"}
        ratios += [2.0 * abs(row.in_scatter or 0.0) for row in wanted]
    count = len(ratios)
    assert count == 10 * 2 * len(run.loops)
    for probability in (0.5, 0.95):
        within = int(np.sum(np.array(ratios) < t.ppf(0.5 + 0.5 * probability, df=3)))
        assert binom.ppf(0.005, count, probability) <= within <= binom.ppf(0.995, count, probability)


@pytest.mark.slow
def test_repeats_that_agree_by_chance_scatter_no_less_than_their_loops_are_unsure(run: RunResult) -> None:
    record = record_of_result(run, sensor=NOISY, repeats=4, seed=5, samples=256)
    twins = [dataclasses.replace(loop, repeat=repeat) for loop in record.loops if loop.repeat == 1 for repeat in (1, 2)]
    rows = [compare(run, dataclasses.replace(record, loops=tuple(loops), scars=(), evolution=())).differences
            for loops in (record.loops, twins)]  # fmt: skip
    true, chance = (next(row.scatter for row in own if row.quantity == "displacement amplitude δa") for own in rows)
    assert true is not None
    assert chance == pytest.approx(true, rel=0.3)


@pytest.mark.parametrize("shift", [(0.0, 0.0), (23.0, -14.0)])
@pytest.mark.parametrize("turn_deg", [0.0, 8.0])
def test_registration_finds_shift_and_rotation_of_a_noisy_map(shift: tuple[float, float], turn_deg: float) -> None:
    simulated = bowl("moving", 12.0, 120.0, 60.0)
    x, y = np.arange(-200.0, 201.0, 10.0), np.arange(-150.0, 151.0, 10.0)
    cosine, sine = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    from_x, from_y = np.meshgrid(x - shift[0], y - shift[1], indexing="ij")
    depth = simulated.depth_at(from_x * cosine + from_y * sine, from_y * cosine - from_x * sine)
    noise = 0.05 * np.random.default_rng(1).standard_normal(depth.shape)
    depth = np.where(np.random.default_rng(2).random(depth.shape) < 0.02, np.nan, np.maximum(depth + noise, 0.0))
    found = register(MeasuredScar(1, "moving", x, y, depth), simulated)
    assert not found.rotation_held
    np.testing.assert_allclose((found.shift_x_um, found.shift_y_um), shift, atol=0.3)
    assert found.rotation_deg == pytest.approx(turn_deg, abs=0.3)
    assert abs(found.shift_x_um - shift[0]) < 5.0 * found.shift_x_deviation_um


def test_a_run_and_a_record_of_other_conditions_are_not_compared_without_a_word(run: RunResult, tmp_path: Path) -> None:
    record = record_of_result(run)
    assert compare(run, record).unlike is None
    conditions = {"normal_load_N": 5.0, "displacement_amplitude_um": 30.0, "cycles": 200_000}
    wires = {"diameter_mm": 0.6, "crossing_angle_deg": 60.0}
    tables = record.tables.model_copy(
        update={
            "conditions": record.tables.conditions.model_copy(update=conditions),
            "wires": record.tables.wires.model_copy(update=wires),
        }
    )
    other = dataclasses.replace(record, tables=tables, scars=())
    comparison = compare(run, other)
    assert comparison.unlike is not None
    for key in ("normal_load_N is 2 in the run and 5 in the record", *conditions, *wires):
        assert key in comparison.unlike
    write_result(tmp_path / "result.h5", run)
    write_record(tmp_path / "record", other)
    call = ["compare", str(tmp_path / "result.h5"), str(tmp_path / "record"), "--output", str(tmp_path / "out")]
    assert comparison.unlike in wirewear(*call).stderr
    assert json.loads((tmp_path / "out" / "differences.json").read_text())["unlike_conditions"] == comparison.unlike
    page = (tmp_path / "out" / "comparison.html").read_text(encoding="utf-8")
    assert comparison.unlike in html.unescape(page.partition("<details>")[0])
