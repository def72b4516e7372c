"""The steel-wire study's comparison: its verdicts follow the results, either way."""

import dataclasses
from pathlib import Path

import pytest

from studies.steel_wires.closed_forms import first_loop_comparisons
from studies.steel_wires.compare import EXAMPLE_RECORD, beside_record, compliant_run_is_nearer
from studies.steel_wires.pair import Pair
from tests.synthetic_results import result
from wirewear import read_record
from wirewear.base.verdicts import Comparison
from wirewear.results import RunResult
from wirewear.study import load_study

STUDY = load_study(Path(__file__).parent.parent / "studies" / "steel_wires" / "study.toml")

#: Springs whose loops resemble the closed form's: rig and contact in series, and the contact alone.
COMPLIANT_N_per_mm, RIGID_N_per_mm = 157.3, 2500.0


@pytest.mark.parametrize(
    ("simulated", "holds"), [(99.1, True), (100.9, True), (98.9, False), (101.1, False), (float("nan"), False)]
)
def test_figures_agree_within_the_tolerance_only(simulated: float, holds: bool) -> None:
    assert Comparison("x", simulated, 100.0, 0.01, "by hand").holds is holds


def run(variant: str, stiffness_N_per_mm: float) -> RunResult:
    made_up = result(variant, stiffness_N_per_mm)
    return dataclasses.replace(
        made_up, study=STUDY.variant(variant).resolved(), settings={"fresh_max_pressure_MPa": 4700.0}
    )


@pytest.fixture
def pair() -> Pair:
    return Pair(rigid=run("rigid", RIGID_N_per_mm), compliant=run("compliant", COMPLIANT_N_per_mm))


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


@pytest.mark.seconds
def test_the_example_record_is_nearer_to_the_run_that_has_its_stiffness(pair: Pair) -> None:
    record = read_record(EXAMPLE_RECORD)
    beside = beside_record(pair, record)
    assert compliant_run_is_nearer(beside).holds
    swapped = {"compliant": beside["rigid"], "rigid": beside["compliant"]}
    assert not compliant_run_is_nearer(swapped).holds
