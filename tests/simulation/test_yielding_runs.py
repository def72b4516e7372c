"""Studies whose bodies state where they yield: the limit of their pressure, their runs, and what results keep."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from solvers.stress.pressing import largest_MPa
from tests.commands import wirewear
from tests.studies import line_study
from wirewear.reference import first_yield_ratio, kept_approach
from wirewear.results import RunResult, read_result, write_result
from wirewear.results.health import limit_of
from wirewear.simulation import simulate
from wirewear.simulation.near_zone import NearZone, near_zone_of
from wirewear.simulation.observers import Observer
from wirewear.simulation.yielding import limit_of_points
from wirewear.test import Study, study_from_tables


def wires(crossing_angle_deg: float = 90.0, **further: Any) -> Study:
    """Steel wires of 0.45 mm under 2 N."""
    tables = {
        "format": 1,
        "name": "wires",
        "kind": "crossed-wires",
        "wires": {
            "diameter_mm": 0.45, "youngs_modulus_MPa": 208_700.0, "poissons_ratio": 0.3,
            "crossing_angle_deg": crossing_angle_deg,
        } | further.pop("wires", {}),
        "conditions": {"normal_load_N": 2.0, "displacement_amplitude_um": 20.0, "frequency_Hz": 3.0, "cycles": 2},
        "contact": {"friction": 0.6} | further.pop("contact", {}),
        "wear": {"energy_wear_coefficient_mm3_per_J": 3e-5},
        **further,
    }  # fmt: skip
    study = study_from_tables(tables, "wires.toml")
    assert isinstance(study, Study)
    return study


@pytest.mark.parametrize(
    ("axis_ratio", "poissons_ratio", "expected"),
    [(1.0, 0.25, 1.554), (1.0, 0.3, 1.613), (1.0, 0.4, 1.739), (0.4, 0.3, 1.653), (0.0, 0.3, 1.794)],
)
def test_bodies_yield_first_where_von_mises_stress_of_hertz_contacts_says(
    axis_ratio: float, poissons_ratio: float, expected: float
) -> None:
    assert first_yield_ratio(axis_ratio, poissons_ratio) == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize(("crossing_angle_deg", "load_N"), [(90.0, 0.487), (45.0, 0.853), (20.0, 2.40)])
def test_load_at_first_yield_is_that_of_the_ellipse_at_any_crossing_angle(
    crossing_angle_deg: float, load_N: float
) -> None:
    limit = limit_of_points(wires(crossing_angle_deg, wires={"yield_stress_MPa": 1800.0}))
    assert limit is not None
    assert limit.first_yield_load == pytest.approx(load_N, rel=0.01)


@pytest.mark.parametrize(("stress_MPa", "fresh_MPa"), [(1400.0, 2889.0), (1800.0, 3556.0), (2400.0, 4273.0)])
def test_largest_pressure_of_fresh_wires_is_that_of_finite_elements(stress_MPa: float, fresh_MPa: float) -> None:
    limit = limit_of_points(wires(wires={"yield_stress_MPa": stress_MPa}))
    assert limit is not None
    assert float(limit.limit_MPa(2.0)) == pytest.approx(fresh_MPa, rel=0.04)


def test_the_softer_body_takes_the_print_and_one_key_keeps_bodies_elastic() -> None:
    softer = {"yield_stress_MPa": 1800.0, "moving": {"yield_stress_MPa": 900.0}}
    limits = [
        limit_of_points(wires(wires=stated, contact=contact))
        for stated, contact in (
            ({"yield_stress_MPa": 900.0}, {}),
            (softer, {}),
            ({"fixed": {"yield_stress_MPa": 900.0}}, {}),
            ({}, {}),
            (softer, {"plasticity": "none"}),
        )
    ]
    assert [None if limit is None else limit.upper_share for limit in limits] == [0.5, 0.0, 1.0, None, None]
    assert {limit.yield_stress_MPa for limit in limits if limit is not None} == {900.0}


def test_an_effect_of_another_yield_stress_is_that_of_the_body_which_yields_first() -> None:
    changed = [{"name": "plasticity", "yield_stress_MPa": 900.0}]
    alike, softer = ({"yield_stress_MPa": stress} for stress in (1800.0, 1500.0))
    for stated, meant in (({}, {}), (alike, {}), (alike | {"moving": softer}, {"moving": True})):
        own = {"moving": {"yield_stress_MPa": 900.0}} if meant else {"yield_stress_MPa": 900.0}
        assert limit_of_points(wires(wires=stated, effects=changed)) == limit_of_points(wires(wires=own))
    imposed = wires(wires=alike, effects=[{"name": "plasticity", "flattening_um": 1.0}])
    assert limit_of_points(imposed) == limit_of_points(wires(wires=alike))


@pytest.mark.parametrize(
    ("load_N", "contact_um", "radius_mm", "yield_MPa", "print_um"),
    [
        (2.0, 14.33, 0.225, 1400.0, 0.232), (50.0, 55.5, 0.5, 1600.0, 2.69), (300.0, 217.0, 1.75, 170.0, 52.0),
        (100.0, 128.0, 3.175, 800.0, 1.56), (500.0, 218.0, 3.175, 800.0, 9.9), (2.0, 14.33, 0.225, 3000.0, 0.0),
    ],
)  # fmt: skip
def test_approach_that_bodies_keep_is_that_of_runs_in_closed_form(
    load_N: float, contact_um: float, radius_mm: float, yield_MPa: float, print_um: float
) -> None:
    assert 1e3 * kept_approach(load_N, 1e-3 * contact_um, radius_mm, yield_MPa) == pytest.approx(print_um, rel=0.1)


@pytest.fixture(scope="module")
def run() -> RunResult:
    """Two cycles at coarse elements."""
    return simulate(wires(wires={"yield_stress_MPa": 1400.0}), fidelity="quick")


@pytest.mark.seconds
def test_a_run_keeps_prints_beside_what_has_worn(run: RunResult, tmp_path: Path) -> None:
    evolution, (moving, fixed) = run.evolution, run.scars[-2:]
    limit = float(run.settings["fresh_pressure_limit_MPa"])
    assert evolution["max_pressure_MPa"].max() == pytest.approx(limit, rel=0.02)
    assert evolution["print_fixed_um"][0] > evolution["print_moving_um"][0] > 0.05
    assert evolution["max_depth_fixed_um"][-1] < 0.05
    assert run.quality["volume_against_energy"] < 1e-6
    assert run.quality["pressure_against_strength"] < 1.0
    assert fixed.print_um is not None
    assert fixed.depth_at(0.0, 0.0) == pytest.approx(fixed.measured_depth_um.max(), rel=1e-6)
    again = write_result(tmp_path / "result.h5", run)
    assert again is not run
    kept = read_result(tmp_path / "result.h5").scars[-1].print_um
    assert kept is not None
    assert np.array_equal(kept, fixed.print_um)
    assert moving.print_um is not None
    said = wirewear("strength", tmp_path / "result.h5", "--cycle", 1, "--body", "fixed", "--output", tmp_path / "s")
    assert "yields at 1400 MPa from cycle 1" in said.output


def near_zone(yield_MPa: float, friction: float) -> NearZone:
    """Steel wires whose metal flows, as a run takes them."""
    contact = {"friction": friction, "plasticity": "near zone"}
    found = near_zone_of(wires(wires={"yield_stress_MPa": yield_MPa}, contact=contact))
    assert found is not None
    return found


def test_metal_that_flows_is_named_before_it_is_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    said, observer = list[str](), Observer()
    monkeypatch.setattr(observer, "note", said.append)
    monkeypatch.setattr("wirewear.simulation.point_runs.near_zone_of", lambda _: pytest.fail("; ".join(said)))
    study = wires(wires={"yield_stress_MPa": 1800.0}, contact={"friction": 0.0, "plasticity": "near zone"})
    with pytest.raises(pytest.fail.Exception, match="metal that flows"):
        simulate(study, fidelity="quick", observer=observer)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("yield_MPa", "pressure_MPa", "radius_um", "print_um"),
    [(1400.0, 2952.0, 16.2, 0.120), (1800.0, 3556.0, 15.1, 0.063), (2400.0, 4273.0, 14.6, 0.014)],
)
def test_wires_whose_metal_flows_are_pressed_as_finite_elements_say(
    yield_MPa: float, pressure_MPa: float, radius_um: float, print_um: float
) -> None:
    near = near_zone(yield_MPa, 0.0)
    grid, settings = near.pressing, near.settings
    upper, lower = grid.rubbed.pressed
    pressure, cell = -upper.traction_MPa[..., 2], float(np.diff(grid.axes_mm[0][:2])[0]) ** 2
    assert largest_MPa(pressure) == pytest.approx(pressure_MPa, rel=0.015)
    assert 1e3 * (cell * (pressure > 0.0).sum() / np.pi) ** 0.5 == pytest.approx(radius_um, rel=0.03)
    for body in (upper, lower):
        assert -1e3 * body.residual_mm[..., 2].min() == pytest.approx(print_um, rel=0.1)
    assert settings["fresh_flow_energy_error"] == grid.rubbed.book.missing
    assert 0.0 < grid.rubbed.book.missing < 0.5 * limit_of("flow_energy")


@pytest.mark.slow
def test_sliding_metal_shakes_down_below_the_limit_and_ratchets_above_it() -> None:
    """Largest pressures of 1.8 and 2.1 yield stresses; Melan's limit is 2.39 at a friction of 0.1, 0.93 at 0.62."""
    below, above = (near_zone(*own).sliding.rubbed for own in ((2400.0, 0.1), (1400.0, 0.62)))
    assert not below.endless
    assert max(below.book.missing, above.book.missing) < limit_of("flow_energy")
    assert (below.cycles[-1].through, below.cycles[-1].skin) == (0.0, 0.0)
    elastic = 1400.0 / 208_700.0
    assert above.cycles[-1].through > 0.5 * elastic
    assert above.cycles[-1].left > 0.02 * elastic


def test_a_line_contact_far_beyond_first_yield_is_pressed_on_a_patch_that_holds_it() -> None:
    steel, drive = {"youngs_modulus_MPa": 208_000.0}, {"displacement_amplitude_um": 0.5, "cycles": 1}
    study = line_study(
        pad={"radius_mm": 5.0, "yield_stress_MPa": 400.0} | steel, specimen=steel, wear=None, log=None, mesh=None,
        conditions=drive | {"normal_load_N_per_mm": 1000.0}, contact={"friction": 0.0},
    )  # fmt: skip
    result = simulate(study, fidelity="quick")
    assert 1000.0 / result.settings["fresh_first_yield_load_N"] == pytest.approx(14.1, rel=0.01)
    largest, limit = (float(result.settings[f"fresh_{key}_MPa"]) for key in ("max_pressure", "pressure_limit"))
    assert limit < largest < 1.03 * limit
    assert 0.5 * 1000.0 / limit < result.settings["patch_half_width_um"] * 1e-3
    assert float(result.evolution["print_pad_um"][-1]) > 1.0
    # 0.2 a/R; the elastic rim widens what carries the limit.
    assert result.quality["indentation_strain"] == pytest.approx(0.2 * 0.5 * 1000.0 / limit / 5.0, rel=0.25)


@pytest.mark.seconds
def test_a_polymer_that_a_roller_strains_by_more_than_ten_per_cent_is_beyond_small_strains() -> None:
    steel, polymer = {"youngs_modulus_MPa": 208_000.0}, {"youngs_modulus_MPa": 3600.0, "poissons_ratio": 0.4}
    study = line_study(
        pad={"radius_mm": 5.0} | steel, specimen={"yield_stress_MPa": 100.0} | polymer, wear=None, log=None, mesh=None,
        conditions={"displacement_amplitude_um": 20.0, "cycles": 1, "normal_load_N_per_mm": 1500.0},
        contact={"friction": 0.2},
    )  # fmt: skip
    result = simulate(study, fidelity="quick")
    strain = result.quality["indentation_strain"]
    assert strain > limit_of("indentation_strain") == 0.1
    # 0.2 a/R of a contact that bears the limit all over.
    assert strain == pytest.approx(0.2 * 750.0 / float(result.settings["fresh_pressure_limit_MPa"]) / 5.0, rel=0.05)
