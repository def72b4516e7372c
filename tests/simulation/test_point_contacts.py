"""Contacts at a point of any two bodies: a ball on a flat by kind and by shape, and crossed cylinders in its place."""

from copy import deepcopy
from math import acos, pi, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geometry import WireGeometry, build_body
from studies.benchmarks.random_draws import LARGEST_PRESSURE_MPa, draw_shapes
from tests.simulation.point_contacts import FRICTION, LOAD_N, STEEL, TEST, RADIUS_mm
from wirewear import parse_study, reference
from wirewear.base.errors import AssumedWarning, StudyError
from wirewear.results import RunResult, read_result
from wirewear.simulation import discretise, run_study
from wirewear.simulation.problem import held_is_primary
from wirewear.sweeps.sweep import figures_of
from wirewear.test import Study, study_from_tables
from wirewear.test.bodies import Wire
from wirewear.test.gaps import hertz_of

BALL = {"kind": "ball-on-flat", "bodies": {"ball": {"diameter_mm": 2 * RADIUS_mm, **STEEL}, "flat": STEEL}}


def cylinder(axis_angle_deg: float, **changes: Any) -> dict[str, Any]:
    return {"shape": "cylinder", "diameter_mm": 2 * RADIUS_mm, "axis_angle_deg": axis_angle_deg, **STEEL} | changes


def bodies(lower: dict[str, Any], upper: dict[str, Any]) -> dict[str, Any]:
    return {"kind": "point-contact", "bodies": {"lower": lower, "upper": upper}}


CROSSED = bodies(cylinder(0.0), cylinder(90.0))


def study(contact: dict[str, Any], **tables: Any) -> Study:
    found: Study = study_from_tables(deepcopy(TEST) | deepcopy(contact) | tables, "s.toml")
    return found


def refusal(contact: dict[str, Any], **tables: Any) -> str:
    with pytest.raises(StudyError) as caught:
        study(contact, **tables)
    return str(caught.value)


def test_a_ball_on_a_flat_is_the_short_form_of_two_shapes_and_touches_as_crossed_cylinders() -> None:
    spelled = bodies({"shape": "flat", **STEEL}, {"shape": "ball", "diameter_mm": 2 * RADIUS_mm, **STEEL})
    short, long = (discretise(study(contact), "standard") for contact in (BALL, spelled))
    assert (short.moving, short.fixed, short.expected) == (long.moving, long.fixed, long.expected)
    steel = reference.Elastic(210000.0, 0.3)
    sphere = reference.hertz_point(LOAD_N, RADIUS_mm, reference.contact_modulus(steel, steel))
    for contact in (BALL, CROSSED):
        hertz = discretise(study(contact), "quick").hertz
        assert hertz.peak_pressure_MPa == pytest.approx(sphere.peak_pressure_MPa)
        assert hertz.approach_mm == pytest.approx(sphere.approach_mm)


def test_a_tube_is_meshed_with_its_bore_and_held_where_it_is_said_to_be() -> None:
    tube = cylinder(90.0, shape="tube", bore_mm=10.0, held_at="ends")
    held = discretise(study(bodies(cylinder(0.0), tube)), "quick").fixed
    assert isinstance(held, WireGeometry)
    assert (held.diameter_mm, held.bore_mm, held.gripped_at_ends) == (12.7, 10.0, True)


@pytest.mark.parametrize(("along_mm", "across_mm"), [(36.0, 12.7), (12.7, 36.0), (170.0, 4.0)])
def test_a_barrel_may_have_any_two_radii(along_mm: float, across_mm: float) -> None:
    barrel = {"shape": "barrel", "diameter_along_mm": along_mm, "diameter_mm": across_mm, **STEEL}
    meshed = discretise(study(bodies({"shape": "flat", **STEEL}, barrel), wear=None), "quick").fixed
    assert build_body(meshed).smallest_scaled_jacobian > 0.25


@pytest.mark.parametrize("angle_deg", [5.0, 15.0, 90.0])
def test_cylinders_cross_at_any_angle_from_5_degrees(angle_deg: float) -> None:
    long = discretise(study(bodies(cylinder(0.0), cylinder(angle_deg)), wear=None), "quick")
    # 4AB = sin²ω/R², A + B = 1/R: the half-angle of the crossing gives the gap's curvatures.
    small, large, _ = long.expected.gap
    assert small / large == pytest.approx(np.tan(0.5 * np.radians(angle_deg)) ** 2)
    assert long.fixed.axial.half_extent_mm > 2.4 * long.expected.fresh.reach(np.radians(angle_deg)) * (1.0 - 1e-9)


UNLIKE = ({"diameter_mm": 0.45, **STEEL}, {"diameter_mm": 0.6, "material": "Ti-6Al-4V"})


def wires(*axes_deg: float, unlike: tuple[dict[str, Any], ...] = UNLIKE) -> dict[str, Any]:
    turned = [{**own, "axis_angle_deg": axis} for own, axis in zip(unlike, axes_deg, strict=True)]
    return {"kind": "crossed-wires", "bodies": dict(zip(("moving", "fixed"), turned, strict=True))}


@pytest.mark.parametrize(("moving_deg", "fixed_deg"), [(0.0, 10.0), (20.0, 0.0), (-35.0, 50.0), (0.0, 175.0)])
def test_crossed_wires_are_the_short_form_of_a_point_contact_at_any_angle(moving_deg: float, fixed_deg: float) -> None:
    """Stated as both wires with what one has different, by their bodies, or as shapes of a point contact."""
    stated = {**UNLIKE[0], "fixed": UNLIKE[1], "crossing_angle_deg": (fixed_deg - moving_deg) % 180.0}
    asked = TEST["conditions"] | {"normal_load_N": 2.0, "cycles": 1000}
    as_points = [
        study({"kind": "crossed-wires", "wires": stated}, conditions=asked | {"motion_angle_deg": -moving_deg}),
        study(wires(moving_deg, fixed_deg), conditions=asked),
    ]
    own = [{"shape": "wire"} | one for one in wires(moving_deg, fixed_deg)["bodies"].values()]
    point, *both = (discretise(each, "quick") for each in (study(bodies(*own), conditions=asked), *as_points))
    for one in both:
        assert one.hertz.peak_pressure_MPa == pytest.approx(point.hertz.peak_pressure_MPa)
        for own_mesh, mesh in ((one.moving, point.moving), (one.fixed, point.fixed)):
            assert own_mesh.axial.lines() == pytest.approx(mesh.axial.lines())
            assert own_mesh.transverse.lines() == pytest.approx(mesh.transverse.lines())


@pytest.mark.parametrize(("angle_deg", "motion_deg"), [(35.0, 0.0), (10.0, -20.0), (150.0, 30.0)])
def test_a_crossing_angle_counts_where_both_wires_state_all_else_and_so_does_what_they_share(
    angle_deg: float, motion_deg: float
) -> None:
    soft = {"youngs_modulus_MPa": 110000.0, "poissons_ratio": 0.34}
    own = {"moving": {"diameter_mm": 0.6, "length_mm": 7.0}, "fixed": {"diameter_mm": 2.4, **soft}}
    asked = TEST["conditions"] | {"normal_load_N": 1.5, "motion_angle_deg": motion_deg}
    wires = {"crossing_angle_deg": angle_deg, **STEEL, **own}
    test = study({"kind": "crossed-wires", "wires": wires}, conditions=asked)
    shapes = bodies(cylinder(-motion_deg, diameter_mm=0.6), cylinder(angle_deg - motion_deg, diameter_mm=2.4) | soft)
    turned = study(shapes, conditions=TEST["conditions"] | {"normal_load_N": 1.5})
    assert test.crossing_angle_deg == pytest.approx(angle_deg)
    moving, fixed = test.bodies
    assert isinstance(moving, Wire)
    assert isinstance(fixed, Wire)
    assert (moving.length_mm, fixed.length_mm) == (7.0, None)
    assert (moving.youngs_modulus_MPa, fixed.youngs_modulus_MPa) == (210000.0, 110000.0)
    found, exact = (hertz_of(1.5, *one.bodies) for one in (test, turned))
    assert found.peak_pressure_MPa == pytest.approx(exact.peak_pressure_MPa, rel=1e-9)


@pytest.mark.parametrize(
    ("contact", "tables", "says"),
    [
        (bodies(cylinder(0.0), cylinder(1.0)), {}, "touch along a line"),
        (bodies({"shape": "flat", **STEEL}, cylinder(0.0)), {}, "touch along a line"),
        (bodies({"shape": "flat", **STEEL}, {"shape": "flat", **STEEL}), {}, "touch along a line"),
        (bodies(cylinder(0.0), cylinder(90.0, shape="barrel")), {}, "diameter_along_mm"),
        (bodies(cylinder(0.0), {"shape": "ball", **STEEL}), {}, "diameter_mm"),
        (bodies(cylinder(0.0, shape="cube"), cylinder(90.0)), {}, "shape"),
        (bodies(cylinder(0.0), cylinder(90.0, shape="tube")), {}, "bore_mm"),
        (bodies(cylinder(0.0), cylinder(90.0, shape="wire", bore_mm=3.0)), {}, "bore_mm"),
        (bodies(cylinder(0.0), cylinder(90.0, shape="tube", bore_mm=12.6)), {}, "a bore of at most 12.19 mm"),
        (bodies(cylinder(0.0), cylinder(90.0, held_at="ends")), {}, "held_at"),
        (BALL, {"conditions": TEST["conditions"] | {"motion_angle_deg": 20.0}}, "motion_angle_deg"),
        (BALL, {"scatter": {"crossing_angle_deg": 1.0}}, "crossing_angle_deg"),
        (BALL, {"effects": [{"name": "crossing_angle_error", "angle_deg": 2.0}]}, "crossing_angle_error"),
        (BALL, {"wires": {"diameter_mm": 0.45}}, "wires"),
        (wires(0.0, 4.0), {}, "crossing_angle_deg"),
        *(
            (wires(axis, 90.0), {"conditions": TEST["conditions"] | {"motion_angle_deg": motion}}, "give it as well")
            for axis in (0.0, 20.0)
            for motion in (0.0, 30.0)
        ),
        (wires(0.0, "20"), {}, "bodies in s.toml give an axis_angle_deg that"),  # type: ignore[arg-type]
        (wires(0.0, 90.0, unlike=({"shape": "tube"}, {})), {}, "give a 'tube'"),
        (wires(0.0, 90.0, unlike=(UNLIKE[0], {**UNLIKE[1], "diameter": 0.6})), {}, "in [bodies.fixed]"),
        (
            {"kind": "crossed-wires", "wires": {"crossing_angle_deg": 35.0, **wires(0.0, 90.0)["bodies"]}},
            {},
            "beside an",
        ),
        (
            wires(0.0, 5.0, unlike=({**STEEL, "diameter_mm": 0.1}, {**STEEL, "diameter_mm": 9.0})),
            {},
            "touch along a line",
        ),
        ({"kind": "ball-on-flat", "bodies": {"ball": STEEL, "flat": STEEL}}, {}, "diameter_mm"),
    ],
)
def test_what_is_no_contact_at_a_point_is_refused(contact: dict[str, Any], tables: dict[str, Any], says: str) -> None:
    message = refusal(contact, **tables)
    assert says in message
    assert "\n" not in message


def test_what_the_fixed_wire_takes_over_from_the_moving_one_is_said() -> None:
    moving, fixed = {"diameter_mm": 0.4, **STEEL}, {"youngs_modulus_MPa": 210000.0}
    with pytest.warns(AssumedWarning, match="the fixed wire states no diameter_mm, no poissons_ratio") as said:
        found = study(wires(0.0, 90.0, unlike=(moving, fixed)))
    assert len(said) == 1
    assert {min(wire.diameters_mm) for wire in found.bodies} == {0.4}


def test_a_test_too_hard_for_a_small_ball_is_refused_before_it_is_meshed() -> None:
    small = {"kind": "ball-on-flat", "bodies": {"ball": {"diameter_mm": 0.1, **STEEL}, "flat": STEEL}}
    with pytest.raises(StudyError, match="the ball is too small for this test"):
        discretise(study(small), "quick")


DIFFERING: list[dict[str, Any]] = [
    cylinder(60.0, diameter_mm=8.0), cylinder(60.0, youngs_modulus_MPa=110000.0), cylinder(80.0),
    {"shape": "ball", "diameter_mm": 8.0, **STEEL},
    cylinder(60.0, diameter_mm=8.0, yield_stress_MPa=900.0),
]  # fmt: skip


@pytest.mark.parametrize("moving_share", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("upper", DIFFERING)
def test_tractions_stay_on_the_same_of_two_bodies_when_they_are_exchanged(
    upper: dict[str, Any], moving_share: float
) -> None:
    wear, lower = {"energy_wear_coefficient_mm3_per_J": 2e-5}, cylinder(20.0)
    one = study(bodies(lower, upper), wear=wear | {"moving_share": moving_share})
    other = study(bodies(upper, lower), wear=wear | {"moving_share": 1.0 - moving_share})
    assert held_is_primary(one) != held_is_primary(other)


@pytest.fixture(scope="module")
def ball(tmp_path_factory: pytest.TempPathFactory) -> RunResult:
    return run(BALL, tmp_path_factory.mktemp("ball"))


def run(contact: dict[str, Any], output: Path) -> RunResult:
    (result,) = run_study(study(contact), fidelity="quick", output=output)
    return result


@pytest.mark.slow
def test_a_run_of_a_ball_wears_both_bodies_by_energy_and_is_its_own_mirror_image(ball: RunResult) -> None:
    assert (ball.contact_kind, ball.bodies) == ("ball-on-flat", ("flat", "ball"))
    energy, evolution = ball.evolution["accumulated_energy_J"], ball.evolution
    assert ball.worn_volume_mm3 == pytest.approx(2.0e-5 * energy, rel=1e-9)
    assert evolution["worn_volume_flat_mm3"] == pytest.approx(0.3 * ball.worn_volume_mm3, rel=1e-9)
    assert evolution["max_tangential_force_N"][0] == pytest.approx(FRICTION * LOAD_N, rel=1e-3)
    assert evolution["mirror_error"].max() < 1e-6
    assert ball.settings["fresh_max_pressure_MPa"] == pytest.approx(ball.settings["hertz_pressure_MPa"], rel=0.03)
    flat, worn_ball = (ball.scar(20, body) for body in ball.bodies)
    assert np.ptp(flat.axial_um) - np.ptp(worn_ball.axial_um) == pytest.approx(80.0)
    for scar in (flat, worn_ball):
        for axis in (0, 1):
            assert scar.depth_um == pytest.approx(np.flip(scar.depth_um, axis), abs=1e-6 * scar.max_depth_um)


@pytest.mark.slow
def test_a_balls_result_keeps_its_unworn_shape_and_names_bodies_in_sweeps(ball: RunResult) -> None:
    assert ball.path is not None
    again = read_result(ball.path)
    assert again.scar(20, "ball").diameter_along_mm == again.scar(20, "ball").diameter_mm == 2 * RADIUS_mm
    assert again.scar(20, "flat").diameter_mm == np.inf
    assert again.forces(20, "ball").meshed == ball.forces(20, "ball").meshed
    r = 100.0
    assert again.scar(20, "ball").unworn_height_um(0.6 * r, 0.8 * r) == pytest.approx(-0.5 * r**2 / 6350.0, rel=1e-3)
    figures = figures_of(ball)
    assert figures["max_depth_ball_um"] == ball.evolution["max_depth_ball_um"][-1]
    assert figures["max_depth_flat_um"] == ball.evolution["max_depth_flat_um"][-1]
    assert None not in figures.values()


@pytest.mark.slow
def test_crossed_cylinders_wear_as_a_ball_of_their_radius_does(ball: RunResult, tmp_path: Path) -> None:
    """Moved along one cylinder, the gap at every position is that of the ball on the flat, to second order."""
    crossed = run(CROSSED, tmp_path)
    for name in ("dissipated_energy_mJ", "slip_amplitude_um", "max_tangential_force_N", "max_mean_pressure_MPa"):
        assert crossed.evolution[name][-1] == pytest.approx(ball.evolution[name][-1], rel=0.01), name
    assert crossed.worn_volume_mm3[-1] == pytest.approx(ball.worn_volume_mm3[-1], rel=0.01)
    for ours, balls in zip(crossed.bodies, ball.bodies, strict=True):
        depths = crossed.evolution[f"max_depth_{ours}_um"], ball.evolution[f"max_depth_{balls}_um"]
        assert depths[0][-1] == pytest.approx(depths[1][-1], rel=0.01)


@pytest.mark.slow(minutes=2)
def test_a_flat_wears_to_what_a_ball_sunk_by_the_approach_sweeps(tmp_path: Path) -> None:
    """A cap of the sphere, drawn out along the stroke by its segment; at last next to no load is left to deform it."""
    sunk, slid = 0.010, 0.050
    asked = {
        "approach_um": 1e3 * sunk, "displacement_amplitude_um": 1e3 * slid, "normal_load_N": 385.0, "cycles": 10000,
    }  # fmt: skip
    mesh = {"contact_mesh_um": 40.0, "outer_mesh_um": 40.0}
    found, *_ = run_study(
        study(
            BALL,
            conditions=TEST["conditions"] | asked,
            wear={"energy_wear_coefficient_mm3_per_J": 4.0e-4, "moving_share": 1.0},
            log={"loop_cycles": [1, 10000]},
            fidelity={"quick": TEST["fidelity"]["quick"] | mesh},
        ),
        fidelity="quick",
        output=tmp_path,
    )
    half = acos(1.0 - sunk / RADIUS_mm)
    segment = RADIUS_mm**2 * (half - 0.5 * sin(2.0 * half))
    cap = pi * sunk**2 * (RADIUS_mm - sunk / 3.0)
    assert found.evolution["normal_force_N"][-1] < 0.01 * found.evolution["normal_force_N"][0]
    assert found.worn_volume_mm3[-1] == pytest.approx(cap + 2.0 * slid * segment, rel=0.02)
    assert found.evolution["max_depth_flat_um"][-1] == pytest.approx(1e3 * sunk, rel=0.02)


@pytest.mark.slow
def test_wires_at_a_small_angle_press_by_hertz_and_wear_by_energy(tmp_path: Path) -> None:
    asked = TEST["conditions"] | {"normal_load_N": 2.0}
    fine = {"quick": {"increments_per_cycle": 64}}
    (found,) = run_study(study(wires(0.0, 20.0), conditions=asked, fidelity=fine), fidelity="quick", output=tmp_path)
    last = {name: values[-1] for name, values in found.evolution.items()}
    assert found.settings["fresh_max_pressure_MPa"] == pytest.approx(found.settings["hertz_pressure_MPa"], rel=0.05)
    assert last["dissipated_energy_mJ"] == pytest.approx(4e-3 * FRICTION * 2.0 * last["slip_amplitude_um"], rel=0.005)
    assert found.worn_volume_mm3[-1] == pytest.approx(2.0e-5 * last["accumulated_energy_J"], rel=1e-9)
    assert found.quality["mirror_error"] < 0.001


@pytest.mark.parametrize("index", range(6))
def test_random_shapes_are_drawn_so_that_they_touch_at_a_point_and_can_be_meshed(index: int) -> None:
    drawn = draw_shapes(1, index)
    assert drawn == draw_shapes(1, index)
    hertz = discretise(parse_study(drawn, "s.toml"), "quick").hertz
    assert hertz.peak_pressure_MPa < 1.001 * LARGEST_PRESSURE_MPa


@pytest.mark.slow
def test_slip_that_turns_behind_a_soft_rig_is_found(tmp_path: Path) -> None:
    """Directions of slip that were iterated one after the other went round in circles in the first cycle."""
    once = {"conditions": {"cycles": 1}, "log": {"loop_cycles": (1,)}}
    (found,) = run_study(parse_study(draw_shapes(1, 31), "s.toml").changed(once), fidelity="quick", output=tmp_path)
    assert found.quality["loop_area_against_friction_work"] < 0.002
