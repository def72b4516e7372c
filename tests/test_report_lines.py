"""The page of a line contact's run: what the result holds, and a browser that moves through its cycles."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from tests.browser import browser, needs_browser
from tests.synthetic_results import loop, profile
from wirewear.base.errors import ResultError
from wirewear.base.hdf5 import sealed
from wirewear.faces import cli
from wirewear.results import Evolution, RunResult, read_results, write_result
from wirewear.views.run_page import line_page, write_page
from wirewear.views.run_wording import sentence

CYCLES = (1, 100, 10_000)


def result(variant: str = "", depth_um: float = 4.0) -> RunResult:
    """A made-up run: Coulomb loops, parabolic scars whose depth grows with the root of the cycles."""
    x = np.linspace(-500.0, 500.0, 41)
    growth = np.sqrt(np.array(CYCLES) / CYCLES[-1])
    bowl = np.maximum(1.0 - (x / 300.0) ** 2, 0.0)
    n, cycles = len(CYCLES), np.array(CYCLES, dtype=float)
    scars = tuple(
        profile(body, x, share * depth_um * g * bowl, cycle, pressure_MPa=200.0 * bowl, slip_distance_um=80.0 * bowl)
        for cycle, g in zip(CYCLES, growth, strict=True)
        for body, share in (("pad", 0.5), ("specimen", 1.0))
    )
    evolution = {
        "cycle": cycles,
        "displacement_amplitude_um": np.full(n, 60.0),
        "slip_amplitude_um": 50.0 - 2.0 * growth,
        "max_tangential_force_N": np.full(n, 1.24),
        "dissipated_energy_mJ": np.full(n, 0.25),
        "accumulated_energy_J": 0.25e-3 * cycles,
        "max_pressure_MPa": 300.0 - 100.0 * growth,
        "mid_stroke_pressure_MPa": 290.0 - 100.0 * growth,
        "worn_volume_pad_mm3": 0.5e-6 * depth_um * growth * 400.0,
        "worn_volume_specimen_mm3": 1e-6 * depth_um * growth * 400.0,
        "normal_force_N": np.full(n, 2.0),
        "contact_half_width_um": 300.0 * growth,
        "jump_cycles": np.zeros(n),
        "max_depth_pad_um": 0.5 * depth_um * growth,
        "max_depth_specimen_um": depth_um * growth,
    }
    study = {"name": "a cylinder", "kind": "line-contact"}
    quality = {"force_balance": 1e-15}
    return RunResult(
        "a cylinder", variant, "quick", "complete", "", study, tuple(loop(cycle, 2000.0) for cycle in CYCLES),
        Evolution(evolution), scars, {"contact_mesh_um": 10.0}, quality, {}, {},
        contact_kind="line-contact", bodies=("specimen", "pad"), length_mm=1.0,
    )  # fmt: skip


def test_the_sentence_says_what_came_out() -> None:
    assert sentence(result()) == (
        "a cylinder: after 10\u2009000 cycles the surfaces slip ±48 µm of the ±60 µm imposed (at first ±50 µm), in "
        "gross slip throughout. 2.5 J of friction on 1 mm of the contact have worn 2.4·10⁻³ mm³: 2 µm deep in the "
        "pad, 4 µm in the specimen."
    )
    stopped = replace(result(), status="failed", message="no solution")
    assert sentence(stopped).endswith("The run is failed: no solution.")


def test_pressures_are_means_over_a_length_or_those_of_nodes_and_say_so() -> None:
    older = result()
    assert "at a node at mid-stroke" in line_page([older])
    means = {"max_mean_pressure_MPa": 0.9, "mid_stroke_mean_pressure_MPa": 0.8}
    largest = older.evolution["max_pressure_MPa"]
    evolution = {**older.evolution, **{name: share * largest for name, share in means.items()}}
    page = line_page(
        [replace(older, evolution=Evolution(evolution), settings={**older.settings, "pressure_length_um": 35.86})]
    )
    assert "mean over 35.9 µm at mid-stroke" in page
    assert "at a node" not in page


def test_the_command_tells_line_contacts_from_wires_and_takes_all_variants(tmp_path: Path) -> None:
    for variant in ("rigid", "soft"):
        write_result(tmp_path / variant / "result.h5", result(variant))
    assert [run.variant for run in read_results(tmp_path)] == ["rigid", "soft"]
    told = CliRunner().invoke(cli, ["report", str(tmp_path)])
    assert (told.exit_code, told.output.strip()) == (0, str(tmp_path / "report.html"))
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "2 runs: rigid, soft" in text


def test_a_damaged_result_is_told_in_a_sentence_wherever_the_damage_is(tmp_path: Path) -> None:
    path = tmp_path / "result.h5"
    write_result(path, result("rigid"))
    data = path.read_bytes()
    for place in range(0, 2000, 40):
        path.write_bytes(sealed(data[:place] + bytes([data[place] ^ 4]) + data[place + 1 :]))
        told = CliRunner().invoke(cli, ["report", str(tmp_path)])
        assert isinstance(told.exception, SystemExit | None), place


def test_a_run_without_a_cycle_has_no_page() -> None:
    empty = replace(result(), evolution=Evolution({name: column[:0] for name, column in result().evolution.items()}))
    with pytest.raises(ResultError, match="nothing is measured yet"):
        line_page([empty])


@pytest.mark.slow
@needs_browser
def test_the_slider_moves_loop_and_profile_on_a_phone(tmp_path: Path) -> None:
    path = write_page([result("rigid"), result("soft", 8.0)], tmp_path)
    with browser() as page:
        page.open(path, 390, 844, phone=True)
        worn = "document.querySelector('#depth path.worn').getAttribute('d')"
        last = page.value(worn)
        page.value("(s => { s.value = 0; s.dispatchEvent(new Event('input')); })(document.querySelector('#cycle'))")
        assert page.value(worn) != last
        assert page.value("document.querySelectorAll('#loop path.now').length") == 2
        assert page.value("[document.documentElement.scrollWidth, innerWidth]") == [390, 390]
        assert page.problems == []
