"""Maps of many tests: tension at the contact's edge, wear against energy, tests of records and runs, the page."""

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from geometry import Elastic
from tests.browser import page_faults
from tests.commands import wirewear
from tests.records.logger_files import CYLINDER, LOAD_N, DEPTHS_um, LENGTH_mm, line_record
from tests.studies import minimal
from tests.synthetic_loops import partial_slip_loop
from tests.synthetic_results import result
from wirewear.comparison.mapped_tests import fretting_tests, worn_in
from wirewear.comparison.maps import (
    FreshContact,
    RegressionLine,
    edge_tension,
    fresh_contact,
    line_through_origin,
    line_with_threshold,
)
from wirewear.records import read_record, write_record
from wirewear.results import write_result

pytestmark = pytest.mark.seconds
EXAMPLES = Path(__file__).parents[2] / "studies" / "steel_wires" / "example_records"


def contact(stiffness: float | str = 167.0) -> FreshContact:
    found = fresh_contact(minimal() | {"holder": {"tangential_stiffness_N_per_mm": stiffness}})
    assert found is not None
    return found


def test_the_edges_tension_lies_between_those_of_a_pressed_and_a_sliding_sphere() -> None:
    """Hertz: p0 (1 − 2ν)/3; Hamilton 1983: µ p0 π (4 + ν)/8 more."""
    found, own = edge_tension(contact()), contact()
    nu = own.bodies[0].poissons_ratio
    assert found[0] == pytest.approx((1.0 - 2.0 * nu) / 3.0, rel=1e-6)
    assert found[-1] == pytest.approx((1.0 - 2.0 * nu) / 3.0 + own.friction * np.pi * (4.0 + nu) / 8.0, rel=1e-4)
    assert np.all(np.diff(found) > 0.0)


def test_unlike_bodies_are_pressed_as_their_contact_modulus_says_whichever_is_named_first() -> None:
    steel = contact()
    soft = dataclasses.replace(steel, bodies=(steel.bodies[0], Elastic(70e3, 0.33)))
    steel_per_MPa, soft_per_MPa = (
        sum((1.0 - body.poissons_ratio**2) / body.youngs_modulus_MPa for body in one.bodies) for one in (steel, soft)
    )
    assert soft.at(2.0)[1] == pytest.approx((steel_per_MPa / soft_per_MPa) ** (2.0 / 3.0) * steel.at(2.0)[1])
    turned = dataclasses.replace(soft, bodies=soft.bodies[::-1])
    own, other = (one.at(2.0)[0].full_slip_displacement_mm for one in (soft, turned))
    assert own == pytest.approx(other)


@pytest.mark.parametrize("threshold", [0.0, 3.0])
def test_intervals_of_the_regression_hold_the_truth_as_often_as_they_say(threshold: float) -> None:
    random = np.random.default_rng(4)
    energy, slope, held = np.geomspace(5.0, 50.0, 7), 3e-5, []
    for _ in range(1000):
        volume = slope * (energy - threshold) + 1e-4 * random.standard_normal(energy.size)
        line = line_with_threshold(energy, volume) if threshold else line_through_origin(energy, volume)
        low, high = line.slope_interval95
        held.append([low < slope < high, not threshold or line.threshold_interval95[0] < threshold])
    share = np.mean(held, axis=0)
    assert 0.93 < share[0] < 0.97
    assert share[1] > 0.93


@pytest.mark.parametrize("regression", [line_through_origin, line_with_threshold])
def test_a_regression_is_the_same_in_any_unit_of_energy(regression: Callable[..., RegressionLine]) -> None:
    energy, volume = np.geomspace(5.0, 50.0, 7), 3e-5 * np.geomspace(4.0, 52.0, 7)
    known, faint = regression(energy, volume), regression(1e-200 * energy, volume)
    assert 1e-200 * faint.slope_mm3_per_J == pytest.approx(known.slope_mm3_per_J)
    assert 1e-200 * np.array(faint.slope_interval95) == pytest.approx(known.slope_interval95)
    assert 1e200 * np.array(faint.threshold_interval95) == pytest.approx(known.threshold_interval95)


def test_a_measured_test_is_known_by_its_loops_and_scars() -> None:
    (test,) = fretting_tests(EXAMPLES / "rigid_stated_compliant_rig")
    assert (test.source, test.regime, test.repeats) == ("record", "gross slip", 3)
    assert test.displacement_amplitude_um == pytest.approx(60.0, rel=0.01)
    assert test.contact is not None
    # The rig is that of the loops, not the rigid one that its owner states.
    assert 1e3 / test.contact.rig_um_per_N == pytest.approx(167.0, rel=0.06)
    assert test.volume_mm3 / test.energy_J == pytest.approx(3e-5, rel=0.05)


def test_a_repeat_counts_for_wear_only_if_both_its_scars_are_known() -> None:
    record = read_record(EXAMPLES / "rigid_stated_compliant_rig")
    whole = worn_in(record)
    less = dataclasses.replace(record, scars=record.scars[1:])
    assert len(whole) == 3
    assert worn_in(less) == whole[1:] == whole[-2:]


def test_a_simulated_test_has_the_wear_coefficient_of_its_study(tmp_path: Path) -> None:
    run = dataclasses.replace(result("", 167.0), study=minimal() | {"holder": {"tangential_stiffness_N_per_mm": 167.0}})
    write_result(tmp_path / "result.h5", run)
    (test,) = fretting_tests(tmp_path)
    assert (test.source, test.repeats) == ("simulated", 1)
    assert test.volume_mm3 / test.energy_J == pytest.approx(3e-5, rel=1e-6)
    assert test.sliding[0].energy_ratio > 0.8


def test_loops_in_partial_slip_and_in_gross_slip_make_a_mixed_test(tmp_path: Path) -> None:
    run = result("", 167.0)
    sliding = run.loops[-1]
    _, displacement, force = partial_slip_loop(0.8, sliding.time_s.size)
    stuck = dataclasses.replace(run.loops[0], displacement_um=displacement, tangential_force_N=force)
    for loops, regime in (((stuck, sliding), "mixed"), ((stuck,), "partial slip"), ((sliding,), "gross slip")):
        write_result(tmp_path / "result.h5", dataclasses.replace(run, loops=loops))
        assert [test.regime for test in fretting_tests(tmp_path)] == [regime]


def test_line_contacts_share_maps_of_their_own_per_millimetre(tmp_path: Path) -> None:
    folder = write_record(tmp_path / "line", line_record(CYLINDER))
    (test,) = fretting_tests(folder)
    assert test.normal_load_N == pytest.approx(LOAD_N / LENGTH_mm)
    assert test.regime == "gross slip"
    assert test.repeats == 2
    # Parabolas of 600 µm.
    assert test.volume_mm3 == pytest.approx(2.0 / 3.0 * 0.6 * 1e-3 * sum(DEPTHS_um.values()), rel=0.01)
    energy_mJ = line_record(CYLINDER).loops[0].figures(LOAD_N).dissipated_energy_mJ.value
    assert test.energy_J == pytest.approx(1e-3 * energy_mJ * 1000 / LENGTH_mm, rel=0.01)
    assert "P [N/mm]" in wirewear("maps", folder, folder, "--output", tmp_path / "maps").output
    assert "normal_load_N_per_mm" in (tmp_path / "maps" / "tests.csv").read_text(encoding="utf-8")
    page = tmp_path / "maps" / "maps.html"
    assert "no line shows where it begins to slide" in page.read_text(encoding="utf-8")
    assert page_faults(page) == []
    mixed = wirewear("maps", folder, EXAMPLES / "no_gap", "--output", tmp_path / "maps", code=2)
    assert "share no map" in mixed.stderr
