"""Tests of few cycles: what N cycles wear, what their loops enclose, from no friction to much."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from tests.commands import wirewear
from tests.studies import line_study, steel_wires
from tests.synthetic_results import result
from wirewear import parse_study, record_of_result, run_study
from wirewear.base.course import enclosed_energy
from wirewear.loops.sensor import enclosed_area
from wirewear.records.evolution_checks import accumulated_energy_J
from wirewear.results import RunResult
from wirewear.results.health import flagged, health, limit_of
from wirewear.results.summary import summary
from wirewear.simulation import simulate
from wirewear.views.run_words import sentence

pytestmark = pytest.mark.seconds
ALPHA_mm3_per_J = 3e-5
AMPLITUDE_um = 40.0
LINE_AMPLITUDE_um = 25.0


@dataclass(frozen=True)
class Judged:
    quality: Mapping[str, float]


def wires(cycles: int, friction: float = 0.62, rig: str = '"rigid"') -> str:
    text = f"""{steel_wires("few cycles", amplitude_um=AMPLITUDE_um, cycles=cycles)}[wear]
energy_wear_coefficient_mm3_per_J = {ALPHA_mm3_per_J}
[holder]
tangential_stiffness_N_per_mm = {rig}
[mesh]
scar_half_width_um = 60.0
[fidelity.quick]
contact_mesh_um = 8.0
outer_mesh_um = 20.0
"""
    return text.replace("friction = 0.62", f"friction = {friction}")


def line(cycles: int, friction: float = 0.6) -> RunResult:
    study = line_study(
        conditions={"normal_load_N_per_mm": 20.0, "displacement_amplitude_um": LINE_AMPLITUDE_um, "cycles": cycles},
        contact={"friction": friction},
        wear={"pad_energy_mm3_per_J": 1e-5, "specimen_energy_mm3_per_J": 2e-5},
        log={"loop_cycles": [cycles]},
        mesh=None,
    )
    return simulate(study, fidelity="quick")


def run(study: str, folder: Path) -> RunResult:
    return run_study(parse_study(study, "few.toml"), fidelity="quick", output=folder)[0]


def volume_mm3(result: RunResult) -> float:
    return float(result.evolution["worn_volume_moving_mm3"][-1] + result.evolution["worn_volume_fixed_mm3"][-1])


@pytest.mark.first_case
@pytest.mark.parametrize("cycles", [1, 2, 10])
def test_wires_wear_in_every_cycle_of_a_test(cycles: int, tmp_path: Path) -> None:
    result = run(wires(cycles), tmp_path)
    energy_mJ = result.evolution["dissipated_energy_mJ"]
    assert volume_mm3(result) == pytest.approx(1e-3 * ALPHA_mm3_per_J * cycles * energy_mJ[-1], rel=5e-3)
    assert result.evolution["accumulated_energy_J"][-1] == pytest.approx(1e-3 * cycles * energy_mJ[-1], rel=5e-3)
    # So does whoever fits the wear coefficient to what is exported.
    fitted = volume_mm3(result) / (accumulated_energy_J(record_of_result(result), 1) or np.nan)
    assert fitted == pytest.approx(ALPHA_mm3_per_J, rel=5e-3)


@pytest.mark.first_case
@pytest.mark.parametrize("cycles", [1, 2, 10, 1000])
def test_line_contacts_wear_in_every_cycle_of_a_test(cycles: int) -> None:
    evolution = line(cycles).evolution
    energy_mJ = evolution["dissipated_energy_mJ"]
    spent = energy_mJ[0] + enclosed_energy(evolution["cycle"], energy_mJ)
    assert 1e3 * evolution["accumulated_energy_J"][-1] == pytest.approx(spent, rel=5e-3)
    worn = evolution["worn_volume_pad_mm3"][-1] + evolution["worn_volume_specimen_mm3"][-1]
    assert worn == pytest.approx(1e-3 * ALPHA_mm3_per_J * spent, rel=5e-3)


@pytest.mark.first_case
@pytest.mark.parametrize("friction", [0.001, 0.01, 0.62, 1.5])
def test_the_energy_of_a_loop_is_its_area_and_friction_work_at_any_friction(friction: float, tmp_path: Path) -> None:
    result = run(wires(100, friction), tmp_path)
    for loop in result.loops:
        area = 1e-3 * enclosed_area(loop.displacement_um, loop.tangential_force_N)
        (row,) = np.flatnonzero(result.evolution["cycle"] == loop.cycle)
        assert result.evolution["dissipated_energy_mJ"][row] == pytest.approx(area, rel=1e-9)
        assert loop.friction_work_mJ[-1] == pytest.approx(area, rel=2e-3)
        assert area == pytest.approx(4e-3 * friction * 2.0 * AMPLITUDE_um, rel=0.01 + 0.03 * friction)
        # As many as for a contact of much friction, at the most.
        assert loop.displacement_um.size < 180
    assert result.evolution["slip_amplitude_um"] == pytest.approx(AMPLITUDE_um, rel=0.01 + 0.03 * friction)


@pytest.mark.parametrize(("of", "amplitude_um"), [("wires", AMPLITUDE_um), ("line", LINE_AMPLITUDE_um)])
def test_without_friction_bodies_slide_the_whole_stroke_unworn(tmp_path: Path, of: str, amplitude_um: float) -> None:
    result = run(wires(10, 0.0), tmp_path) if of == "wires" else line(10, 0.0)
    evolution = result.evolution
    assert evolution["slip_amplitude_um"] == pytest.approx(amplitude_um, rel=5e-3)
    assert evolution["max_tangential_force_N"].max() < 1e-3
    assert (evolution["dissipated_energy_mJ"] >= 0.0).all()
    assert evolution["dissipated_energy_mJ"].max() < 1e-5
    assert {scar.volume_mm3 for scar in result.scars} == {0.0}
    assert of == "line" or "in gross slip throughout" in sentence(result)


@pytest.mark.first_case
@pytest.mark.parametrize("as_json", [False, True])
def test_a_rig_that_takes_the_whole_stroke_is_the_first_thing_that_a_run_says(as_json: bool, tmp_path: Path) -> None:
    """µP/K = 0.62 x 2 N over 20 N/mm is 62 µm."""
    study, folder = tmp_path / "study.toml", tmp_path / "out"
    study.write_text(wires(2, rig="20.0"), encoding="utf-8")
    options = ["--fidelity", "quick", "--output", str(folder), *(["--json"] if as_json else [])]
    ended = wirewear("run", study, *options)
    said = json.loads(ended.stdout)[0]["sentence"] if as_json else ended.stdout.splitlines()[0]
    sentence = "the rig takes the whole stroke, so the contact sticks at least in its middle: µP/K = 62 µm"
    assert said.startswith(f"few cycles: {sentence}")
    assert "δa = 40 µm" in said
    assert sentence in (folder / "report.html").read_text(encoding="utf-8")


def test_the_command_and_its_json_flag_a_closure_by_the_limit_of_the_page() -> None:
    name = "loop_area_against_friction_work"
    limit = limit_of(name)
    assert limit == 2e-3
    assert health([Judged({name: 0.9 * limit})])[0].sound
    assert not health([Judged({name: 1.1 * limit})])[0].sound
    assert flagged(name, 1.1 * limit).endswith("more than 2.0e-03")
    assert flagged(name, 0.9 * limit) == "1.8e-03"
    for share in (0.9, 1.1):
        console = Console(width=120, record=True, file=StringIO())
        console.print(summary([replace(result(), quality={name: share * limit})]))
        assert ("finer --fidelity" in console.export_text()) is (share > 1.0)
