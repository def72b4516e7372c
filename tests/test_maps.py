"""Maps of many tests: tension at the contact's edge, wear against energy, tests of records and runs, the page."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from tests.browser import TOO_WIDE, browser, needs_browser
from tests.line_logger_files import CYLINDER, LOAD_N, DEPTHS_um, LENGTH_mm, line_record
from tests.studies import minimal
from tests.synthetic_loops import partial_slip_loop
from tests.synthetic_results import result
from wirewear.faces import cli
from wirewear.faces.maps_page import groups, labels_of, write_maps
from wirewear.faces.maps_reading import fretting_tests
from wirewear.faces.maps_tables import maps_json, sentences
from wirewear.faces.maps_values import MappedTest, WornTest
from wirewear.records import read_record, record_of_result, write_record
from wirewear.records.line_files import write_line_record
from wirewear.reference.cattaneo_mindlin import loading_displacement
from wirewear.results import write_result
from wirewear.views.regression import line_through_origin, line_with_threshold
from wirewear.views.response import SHARES, edge_tension, tension_at, tension_lines
from wirewear.views.run_maps import FreshContact, fresh_contact, transition

EXAMPLES = Path(__file__).resolve().parent.parent / "studies" / "steel_wires" / "example_records"


def contact(stiffness: float | str = 167.0) -> FreshContact:
    found = fresh_contact(minimal() | {"holder": {"tangential_stiffness_N_per_mm": stiffness}})
    assert found is not None
    return found


def of_test(worn: list[tuple[float, float]], name: str = "made up") -> MappedTest:
    (measured,) = fretting_tests(EXAMPLES / "no_gap")
    return dataclasses.replace(measured, name=name, worn=tuple(WornTest(*one) for one in worn))


def test_the_edges_tension_lies_between_those_of_a_pressed_and_a_sliding_sphere() -> None:
    """Hertz: p0 (1 − 2ν)/3; Hamilton 1983: µ p0 π (4 + ν)/8 more."""
    found, own = edge_tension(contact()), contact()
    nu = own.bodies[0].poissons_ratio
    assert found[0] == pytest.approx((1.0 - 2.0 * nu) / 3.0, rel=1e-6)
    assert found[-1] == pytest.approx((1.0 - 2.0 * nu) / 3.0 + own.friction * np.pi * (4.0 + nu) / 8.0, rel=1e-4)
    assert np.all(np.diff(found) > 0.0)


def test_a_line_of_tension_is_where_the_tension_is_that() -> None:
    own = contact()
    lines = tension_lines(own, 240.0, (0.2, 20.0))
    assert len(lines) > 1
    for line in lines:
        for x, load in zip(line.displacement_um[1::6], line.normal_load_N[1::6], strict=True):
            assert tension_at(own, float(x), float(load)) == pytest.approx(line.tension_MPa, rel=2e-3)


def test_a_sliding_contact_is_not_pulled_more_by_a_longer_stroke() -> None:
    own = contact()
    slides = float(transition(own, [2.0]).test_um[0])
    assert tension_at(own, 10.0 * slides, 2.0) == pytest.approx(tension_at(own, slides, 2.0), rel=1e-9)
    assert tension_at(own, 0.5 * slides, 2.0) < 0.95 * tension_at(own, slides, 2.0)
    # A Hertz contact's pressure grows with the cube root of the load.
    assert tension_at(own, 1e3, 16.0) == pytest.approx(2.0 * tension_at(own, 1e3, 2.0), rel=1e-6)


def test_a_rig_that_gives_way_takes_tension_off_a_short_stroke() -> None:
    stroke = float(transition(contact("rigid"), [2.0]).test_um[0])
    assert tension_at(contact(50.0), stroke, 2.0) < 0.7 * tension_at(contact("rigid"), stroke, 2.0)
    point, _ = contact().at(2.0)
    assert loading_displacement(point, SHARES[-1] * point.limit_N) == pytest.approx(point.full_slip_displacement_mm)


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


def test_a_line_without_scatter_is_found_exactly() -> None:
    energy = np.array([5.0, 10.0, 30.0])
    found = line_with_threshold(energy, 2e-5 * (energy - 4.0))
    assert (found.slope_mm3_per_J, found.threshold_J, found.explained) == pytest.approx((2e-5, 4.0, 1.0))
    assert line_through_origin(energy, 2e-5 * energy).slope_interval95 == pytest.approx((2e-5, 2e-5))
    assert line_through_origin([2.0], [4e-5]).slope_interval95 == (-np.inf, np.inf)


def test_a_measured_test_is_known_by_its_loops_and_scars() -> None:
    (test,) = fretting_tests(EXAMPLES / "rigid_stated_compliant_rig")
    assert (test.source, test.regime, test.repeats) == ("record", "gross slip", 3)
    assert test.displacement_amplitude_um == pytest.approx(60.0, rel=0.01)
    assert test.contact is not None
    # The rig is that of the loops, not the rigid one that its owner states.
    assert 1e3 / test.contact.rig_um_per_N == pytest.approx(167.0, rel=0.06)
    assert test.volume_mm3 / test.energy_J == pytest.approx(3e-5, rel=0.05)


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


def test_tests_on_the_same_wires_share_one_line() -> None:
    own = fretting_tests(EXAMPLES / "no_gap") + fretting_tests(EXAMPLES / "free_play_rig")
    assert len(groups(own)) == 1
    thicker = dataclasses.replace(contact(), radii_mm=(0.5, 0.5))
    assert len(groups([*own, dataclasses.replace(own[0], contact=thicker)])) == 2


def test_numbers_in_one_place_are_drawn_together() -> None:
    here, there = (60.0, 2.0), (30.0, 2.0)
    assert labels_of([here, here, here, there, here]) == ["1–3, 5", "", "", "4", ""]


def test_a_threshold_is_told_only_where_energies_differ() -> None:
    alike = [of_test([(24.0, 7e-4), (25.0, 7.6e-4), (26.0, 7.7e-4)])]
    assert maps_json(alike)["with_threshold"] is None
    spread = [of_test([(5.0, 3e-5), (25.0, 6.2e-4), (50.0, 1.41e-3), (75.0, 2.1e-3)])]
    found = maps_json(spread)["with_threshold"]
    assert found["threshold_J"] == pytest.approx(4.0, abs=1.0)
    assert "threshold is told from zero" in sentences(spread)[-1]
    assert maps_json([of_test([])])["through_origin"] is None


def test_the_command_draws_records_and_runs_and_prints_json(tmp_path: Path) -> None:
    asked = ["maps", str(EXAMPLES / "no_gap"), str(EXAMPLES / "free_play_rig"), "--output", str(tmp_path), "--json"]
    told = CliRunner().invoke(cli, asked)
    assert told.exit_code == 0, told.output
    assert [row["regime"] for row in json.loads(told.output)["tests"]] == ["gross slip", "gross slip"]
    assert json.loads(told.output)["through_origin"]["tests"] == 6
    assert (tmp_path / "tests.csv").read_text(encoding="utf-8").count("\n") == 3
    assert (tmp_path / "maps.html").is_file()
    told = CliRunner().invoke(cli, ["maps", str(tmp_path / "none")])
    assert (told.exit_code, told.output.count("\n")) == (2, 1)


def test_an_exported_simulation_is_called_simulated_and_a_record_that_says_nothing_neither(tmp_path: Path) -> None:
    write_record(tmp_path / "exported", record_of_result(dataclasses.replace(result(), study=minimal())))
    (exported,) = fretting_tests(tmp_path / "exported")
    assert exported.source == "simulated"
    (own,) = fretting_tests(EXAMPLES / "no_gap")
    assert own.source == "record"


def test_cracks_that_were_found_are_told_and_drawn(tmp_path: Path) -> None:
    record = read_record(EXAMPLES / "no_gap")
    known = record.tables.metadata.model_copy(update={"cracks": "found"})
    write_record(
        tmp_path / "record", dataclasses.replace(record, tables=record.tables.model_copy(update={"metadata": known}))
    )
    (test,) = fretting_tests(tmp_path / "record")
    assert test.cracks == "found"


@pytest.mark.slow
@needs_browser
def test_the_page_draws_its_maps_without_an_error_and_fits_a_phone(tmp_path: Path) -> None:
    spread = of_test([(5.0, 3e-5), (25.0, 6.2e-4), (50.0, 1.41e-3), (75.0, 2.1e-3)], "<b>own</b>")
    partial = dataclasses.replace(spread, regime="partial slip", displacement_amplitude_um=1.0, cracks="found")
    page = write_maps([spread, partial], tmp_path)[0]
    with browser() as shown:
        shown.open(page, 390, 844, phone=True)
        assert shown.value("document.documentElement.scrollWidth") == 390
        assert shown.value(TOO_WIDE) == []
        for chart in ("conditions", "response", "volume", "ratio", "free"):
            assert shown.value(f"document.querySelectorAll('#{chart} svg path').length") > 1
        assert shown.value("document.querySelectorAll('#response path.tension').length") > 0
        assert shown.value("document.querySelectorAll('#response circle[fill=\"#fff\"]').length") == 1
        assert shown.value("document.querySelector('b')") is None
        assert shown.problems == []


def test_line_contacts_share_maps_of_their_own_per_millimetre(tmp_path: Path) -> None:
    folder = write_line_record(tmp_path / "line", line_record(CYLINDER))
    (test,) = fretting_tests(folder)
    assert test.normal_load_N == pytest.approx(LOAD_N / LENGTH_mm)
    assert test.regime == "gross slip"
    assert test.repeats == 2
    # Parabolas of 600 µm.
    assert test.volume_mm3 == pytest.approx(2.0 / 3.0 * 0.6 * 1e-3 * sum(DEPTHS_um.values()), rel=0.01)
    energy_mJ = line_record(CYLINDER).loops[0].figures(LOAD_N).dissipated_energy_mJ.value
    assert test.energy_J == pytest.approx(1e-3 * energy_mJ * 1000 / LENGTH_mm, rel=0.01)
    drawn = CliRunner().invoke(cli, ["maps", str(folder), str(folder), "--output", str(tmp_path / "maps")])
    assert drawn.exit_code == 0, drawn.output
    assert "P [N/mm]" in drawn.output
    assert "normal_load_N_per_mm" in (tmp_path / "maps" / "tests.csv").read_text(encoding="utf-8")
    assert "no line tells where it begins to slide" in (tmp_path / "maps" / "maps.html").read_text(encoding="utf-8")
    mixed = CliRunner().invoke(cli, ["maps", str(folder), str(EXAMPLES / "no_gap"), "--output", str(tmp_path / "maps")])
    assert mixed.exit_code == 2
    assert "share no map" in mixed.stderr
