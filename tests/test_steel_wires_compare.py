"""The steel-wire study's comparison: its verdicts follow the results, either way."""

import dataclasses
import io
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from rich.console import Console
from rich.table import Table

from studies.steel_wires.closed_forms import first_loop_comparisons, volume_comparisons, worn_friction_comparison
from studies.steel_wires.compare import EXAMPLE_RECORD, beside_record, compliant_run_is_nearer, main
from studies.steel_wires.findings import (
    energy_rises,
    extent_along_motion_um,
    fixed_scar_is_shorter_and_deeper,
    friction_for_rising_energy,
    loops_distort,
    rigid_rig_over_predicts_slip,
    scars_grow,
    slip_falls,
    worst_depth_is_bounded,
)
from studies.steel_wires.pair import Pair, read_pair
from tests.picture_pixels import shows
from tests.synthetic_results import bowl, loop, result
from wirewear import read_record
from wirewear.base.errors import ResultError
from wirewear.base.verdicts import Comparison, Finding, comparison_table, finding_table
from wirewear.pictures.colours import VARIANT_COLOURS
from wirewear.results import Evolution, RunResult, write_result
from wirewear.study import load_study

STUDY = load_study(Path(__file__).parent.parent / "studies" / "steel_wires" / "study.toml")

#: Springs whose loops resemble the closed form's: rig and contact in series, and the contact alone.
COMPLIANT_N_per_mm, RIGID_N_per_mm = 157.3, 2500.0


def printed(table: Table) -> str:
    console = Console(width=120, file=io.StringIO(), record=True)
    console.print(table)
    return console.export_text()


@pytest.mark.parametrize(
    ("simulated", "holds"), [(99.1, True), (100.9, True), (98.9, False), (101.1, False), (float("nan"), False)]
)
def test_figures_agree_within_the_tolerance_only(simulated: float, holds: bool) -> None:
    assert Comparison("x", simulated, 100.0, 0.01, "by hand").holds is holds


def test_negative_expectations_have_a_deviation_too() -> None:
    assert Comparison("x", -1.1, -1.0, 0.2, "by hand").deviation == pytest.approx(0.1)


def test_the_table_of_figures_shows_units_difference_and_verdict() -> None:
    text = printed(comparison_table([Comparison("energy [mJ]", 0.25, 0.2, 0.01, "closed form")]))
    assert [word in text for word in ("energy [mJ]", "+25 %", "not within 1 %", "closed form")] == [True] * 4


def test_the_table_of_findings_shows_what_does_not_hold() -> None:
    text = printed(finding_table([Finding("slip falls", "50 → 51 [µm]", holds=False)]))
    assert "does not hold" in text
    assert "50 → 51 [µm]" in text


def run(variant: str, stiffness_N_per_mm: float) -> RunResult:
    made_up = result(variant, stiffness_N_per_mm)
    return dataclasses.replace(
        made_up, study=STUDY.variant(variant).resolved(), settings={"fresh_max_pressure_MPa": 4700.0}
    )


@pytest.fixture
def pair() -> Pair:
    return Pair(rigid=run("rigid", RIGID_N_per_mm), compliant=run("compliant", COMPLIANT_N_per_mm))


def with_compliant(pair: Pair, **changes: object) -> Pair:
    return dataclasses.replace(pair, compliant=dataclasses.replace(pair.compliant, **changes))  # type: ignore[arg-type]


def with_column(pair: Pair, name: str, factor: float, last_only: bool = False) -> Pair:
    column = pair.compliant.evolution[name].copy()
    column[-1 if last_only else slice(None)] *= factor
    return with_compliant(pair, evolution=Evolution({**pair.compliant.evolution, name: column}))


def test_expected_figures_are_those_worked_out_by_hand(pair: Pair) -> None:
    """2 N, µ 0.62, 60 µm, 167 N/mm and 0.45 mm wires give 52.07 and 59.49 µm, 0.2580 and 0.2949 mJ, 4669 MPa."""
    expected = {c.name: c.expected for c in first_loop_comparisons(pair)}
    assert expected["compliant: δ0 [µm]"] == pytest.approx(52.07, abs=0.005)
    assert expected["rigid: δ0 [µm]"] == pytest.approx(59.49, abs=0.005)
    assert expected["compliant: energy per cycle [mJ]"] == pytest.approx(0.2580, abs=1e-4)
    assert expected["rigid: energy per cycle [mJ]"] == pytest.approx(0.2949, abs=1e-4)
    assert expected["displacement taken by rig [µm]"] == pytest.approx(7.43, abs=0.01)
    assert expected["compliant: largest pressure before wear [MPa]"] == pytest.approx(4669, abs=1)
    # Below the initial slope 1/(1/167 + 1/2709) N/mm, for a line is fitted to a curve.
    assert 150.0 < expected["compliant: stiffness K_t,m [N/mm]"] < 157.3


def test_made_up_springs_agree_with_the_closed_form_and_a_wrong_slip_does_not(pair: Pair) -> None:
    """A spring and a Coulomb slider come near the closed form; 3 % more slip is beyond its tolerance."""
    assert all(c.holds for c in first_loop_comparisons(pair))
    failed = {c.name for c in first_loop_comparisons(with_column(pair, "slip_amplitude_um", 1.03)) if not c.holds}
    assert failed == {"compliant: δ0 [µm]", "displacement taken by rig [µm]"}


def test_volume_that_strays_from_the_energy_by_a_hundred_thousandth_is_seen(pair: Pair) -> None:
    assert [c.holds for c in volume_comparisons(pair)] == [True] * 4
    strayed = volume_comparisons(with_column(pair, "worn_volume_fixed_mm3", 1.0 + 1e-5))
    assert [c.holds for c in strayed] == [True, False, True, True]


def test_friction_of_the_last_loop_is_judged_by_its_own_loop(pair: Pair) -> None:
    """A flat loop at µ = 0.62 agrees; one under a normal load misread by 10 % does not."""
    flat = loop(100_000, COMPLIANT_N_per_mm)
    assert worn_friction_comparison(with_compliant(pair, loops=(flat,))).holds
    misread = dataclasses.replace(flat, normal_force_N=1.1 * flat.normal_force_N)
    assert not worn_friction_comparison(with_compliant(pair, loops=(misread,))).holds


def test_finding_1_fails_for_loops_that_stay_flat_or_are_never_flat(pair: Pair) -> None:
    assert loops_distort(pair).holds
    for hook in (0.0, 0.4):
        loops = tuple(loop(cycle, COMPLIANT_N_per_mm, hook) for cycle in (100, 10_000, 100_000))
        assert not loops_distort(with_compliant(pair, loops=loops)).holds


def test_finding_2_fails_for_rising_slip_for_slip_above_the_drive_and_for_a_drifting_drive(pair: Pair) -> None:
    assert slip_falls(pair).holds
    assert not slip_falls(with_column(pair, "slip_amplitude_um", 1.1, last_only=True)).holds
    assert not slip_falls(with_column(pair, "slip_amplitude_um", 1.2)).holds
    assert not slip_falls(with_column(pair, "displacement_amplitude_um", 1.01, last_only=True)).holds


def test_energy_that_falls_contradicts_the_measured_test_and_states_the_friction_that_would_undo_it(pair: Pair) -> None:
    """δa 60, δ0 48.4 µm, 3.5 % less energy at the end: µ 0.62·(1 + 0.035/0.76) = 0.649, the closed form's."""
    energy = np.linspace(0.25, 0.26, len(pair.compliant.evolution["cycle"]))
    rising = Pair(*(with_energy(run, energy) for run in (pair.rigid, pair.compliant)))
    assert energy_rises(rising).holds
    fallen = with_energy(pair.compliant, np.append(energy[:-1], energy[-2] / 1.035))
    assert not energy_rises(dataclasses.replace(rising, compliant=fallen)).holds
    slip = np.full(len(energy), 48.4)
    columns = {**fallen.evolution, "slip_amplitude_um": slip, "displacement_amplitude_um": np.full(len(energy), 60.0)}
    needed = friction_for_rising_energy(dataclasses.replace(fallen, evolution=Evolution(columns)))
    assert needed == pytest.approx(0.649, abs=5e-4)
    # 4 µP (δa − µP/K) at K = µP/(δa − δ0), with both frictions.
    stiffness = 0.62 * 2.0 / (60.0 - 48.4)
    energies = [mu * (60.0 - mu * 2.0 / stiffness) for mu in (0.62, needed)]
    assert energies[1] / energies[0] == pytest.approx(1.035, abs=1e-3)


def with_energy(run: RunResult, energy: np.ndarray) -> RunResult:
    return dataclasses.replace(run, evolution=Evolution({**run.evolution, "dissipated_energy_mJ": energy}))


def test_finding_3_fails_if_the_rigid_rig_slips_less_at_a_single_cycle(pair: Pair) -> None:
    assert rigid_rig_over_predicts_slip(pair).holds
    assert not rigid_rig_over_predicts_slip(with_column(pair, "slip_amplitude_um", 1.25, last_only=True)).holds


def test_finding_4_fails_for_early_depth_and_for_bowls_that_do_not_widen(pair: Pair) -> None:
    assert scars_grow(pair).holds
    late = [scar for scar in pair.compliant.scars if scar.cycle == 100_000]
    for depth, length in ((5.0, 50.0), (0.1, 300.0)):
        early = [bowl(wire, depth, length, length, cycle=100) for wire in ("moving", "fixed")]
        assert not scars_grow(with_compliant(pair, scars=(*early, *late))).holds


def test_the_bound_on_depth_and_the_order_of_the_scars_can_fail(pair: Pair) -> None:
    assert worst_depth_is_bounded(pair).holds
    assert fixed_scar_is_shorter_and_deeper(pair).holds
    deep = (bowl("moving", 41.0, 100.0, 60.0), bowl("fixed", 20.0, 60.0, 60.0))
    assert not worst_depth_is_bounded(with_compliant(pair, scars=deep)).holds
    assert not fixed_scar_is_shorter_and_deeper(with_compliant(pair, scars=deep)).holds


def test_extent_is_measured_where_a_twentieth_of_the_depth_is_worn() -> None:
    """depth·(1 − (x/half)²) = depth/20 at half·√0.95, on both sides."""
    scar = bowl("moving", 10.0, 100.0, 50.0, lines=(601, 41))
    assert extent_along_motion_um(scar) == pytest.approx(200.0 * np.sqrt(0.95), rel=2e-3)


def test_the_example_record_is_nearer_to_the_run_that_has_its_stiffness(pair: Pair) -> None:
    record = read_record(EXAMPLE_RECORD)
    beside = beside_record(pair, record)
    assert compliant_run_is_nearer(beside).holds
    swapped = {"compliant": beside["rigid"], "rigid": beside["compliant"]}
    assert not compliant_run_is_nearer(swapped).holds


@pytest.mark.slow
def test_the_command_prints_verdicts_and_draws_three_pictures_and_two_comparisons_with_the_record(
    pair: Pair, tmp_path: Path
) -> None:
    for one in pair.runs:
        write_result(tmp_path / one.variant / "result.h5", one)
    outcome = CliRunner().invoke(main, [str(tmp_path), "--output", str(tmp_path / "pictures")])
    assert outcome.exit_code == 0, outcome.output
    assert "A rigid rig over-predicts slip throughout" in outcome.output
    pages = sorted((tmp_path / "pictures").glob("*/comparison.html"))
    assert [page.parent.name for page in pages] == ["record_compliant", "record_rigid"]
    pictures = sorted((tmp_path / "pictures").glob("*.png"))
    assert [picture.name for picture in pictures] == ["amplitudes.png", "loops.png", "scar_sections.png"]
    for picture in pictures:
        assert picture.name in outcome.output
        assert shows(picture, *VARIANT_COLOURS[:2])


def test_a_missing_variant_and_another_study_are_one_sentence_each(tmp_path: Path) -> None:
    write_result(tmp_path / "rigid" / "result.h5", result("rigid"))
    outcome = CliRunner().invoke(main, [str(tmp_path)])
    assert outcome.exit_code == 2
    assert "lacks the variant(s) compliant" in outcome.output
    write_result(tmp_path / "compliant" / "result.h5", result("compliant"))
    with pytest.raises(ResultError, match="is no run of this study with wear"):
        read_pair(tmp_path)
