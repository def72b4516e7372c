"""Pads with a cut, a rounded or any measured face, straight or turned, against closed forms and other bodies."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geometry import Cylinder, RoundedFlat, TabledProfile
from solvers import press, unloaded_state
from tests.test.pads import BALL, LINE, POINTS, STEEL, STEEL_MODULUS, BALL_RADIUS_mm, study
from wirewear import reference
from wirewear.base.errors import StudyError
from wirewear.results import RunResult
from wirewear.simulation import run_study, simulate
from wirewear.simulation.discretisation import discretise
from wirewear.simulation.point_runs import PointRun
from wirewear.test import LineStudy, study_from_tables
from wirewear.test.study import read_study

R_mm, MODULUS = 6.0, 115_000.0


def by_file(folder: Path, x_mm: Any, fall_mm: Any, name: str = "study") -> LineStudy:
    """A study beside which lies the profile of its pad, as a profilometer writes it."""
    folder.mkdir(exist_ok=True)
    rows = "\n".join(f"{1e3 * x:.6f},{5.0 - 1e3 * fall:.9f}" for x, fall in zip(x_mm, fall_mm, strict=True))
    (folder / f"{name}.csv").write_text(f"x_um,height_um\n{rows}\n", encoding="utf-8")
    path = folder / f"{name}.toml"
    path.write_text(LINE.format(pad=f'profile_file = "{name}.csv"'), encoding="utf-8")
    found: LineStudy = study_from_tables(read_study(path), str(path))
    return found


def ran(study: LineStudy) -> RunResult:
    return simulate(study, fidelity="quick")


@pytest.fixture(scope="module")
def cylinder(tmp_path_factory: pytest.TempPathFactory) -> RunResult:
    path = tmp_path_factory.mktemp("cylinder") / "study.toml"
    path.write_text(LINE.format(pad=f"radius_mm = {R_mm}"), encoding="utf-8")
    return ran(study_from_tables(read_study(path), str(path)))


def same(first: RunResult, second: RunResult, tolerance: float) -> None:
    for name in ("dissipated_energy_mJ", "max_tangential_force_N", "worn_volume_pad_mm3", "max_depth_specimen_um"):
        assert first.evolution[name][-1] == pytest.approx(second.evolution[name][-1], rel=tolerance), name


@pytest.mark.seconds
def test_a_table_that_holds_a_parabola_is_the_cylinder_and_one_shifted_aside_the_same_beside(
    tmp_path: Path, cylinder: RunResult
) -> None:
    x = np.linspace(-1.2, 1.2, 241)
    same(ran(by_file(tmp_path, x, x**2 / (2.0 * R_mm))), cylinder, 2e-3)
    aside = ran(by_file(tmp_path, x, (x - 0.06) ** 2 / (2.0 * R_mm), "aside"))
    same(aside, cylinder, 5e-3)
    pad, middle = aside.scar(2000, "pad"), cylinder.scar(2000, "pad")
    depth = np.interp(middle.axial_um + 60.0, pad.axial_um, pad.depth_um[:, 0])
    assert np.abs(depth - middle.depth_um[:, 0]).max() < 0.02 * middle.max_depth_um


@pytest.mark.seconds
def test_a_face_turned_about_wears_into_the_mirror_image(tmp_path: Path) -> None:
    x = np.linspace(-1.1, 1.1, 121)
    fall = np.where(x > 0.0, x**2 / 8.0, x**2 / 20.0) + 2e-5 * (1.0 - np.cos(30.0 * x))
    one, other = (ran(by_file(tmp_path, x, own, name)) for own, name in ((fall, "one"), (fall[::-1], "other")))
    for body in ("pad", "specimen"):
        depth, turned = (run.scar(2000, body).depth_um[:, 0] for run in (one, other))
        assert np.abs(depth - turned[::-1]).max() < 0.01 * depth.max()
        assert np.abs(depth - depth[::-1]).max() > 0.1 * depth.max()
    assert one.scar(2000, "pad").depth_um.max() > 0.1


@pytest.mark.parametrize("a", [0.32, 0.5])
def test_loads_of_rounded_and_cut_flats_are_the_closed_forms(a: float) -> None:
    """Ciavarella, Hills and Monno, Proc. IMechE C 212 (1998) 319, for arcs that begin level."""
    b, angle, root = 0.3, np.arccos(0.3 / a), np.sqrt(a**2 - 0.3**2)
    rounded = 0.5 * a**2 * angle - 0.5 * b * root
    cut = 0.5 * a**2 * angle + 0.5 * b * root
    for face, closed in ((RoundedFlat(b, R_mm), rounded), (RoundedFlat(b, R_mm, cut=True), cut)):
        # The closed forms are those of parabolas.
        assert reference.even_line_load(face, a, MODULUS) == pytest.approx(MODULUS * closed / R_mm, rel=0.02)


def test_a_cut_cylinder_falls_as_the_cylinder_beside_its_flat() -> None:
    places = np.column_stack([[-0.7, -0.31, 0.0, 0.2, 0.5], np.zeros(5)])
    cut, whole = RoundedFlat(0.3, R_mm, cut=True), Cylinder(R_mm, curved_along=True)
    brink = whole.height(np.array([[0.3, 0.0]]))
    beside = np.abs(places[:, 0]) > 0.3
    np.testing.assert_allclose(cut.height(places), np.where(beside, whole.height(places) - brink, 0.0), atol=1e-15)
    np.testing.assert_allclose(cut.slope(places), np.where(beside[:, None], whole.slope(places), 0.0), atol=1e-15)


def test_the_even_face_lies_above_an_uneven_one_to_its_shorter_side() -> None:
    uneven = TabledProfile(((-0.4, 0.02), (-0.2, 0.005), (0.1, 0.0), (0.2, 0.001), (0.6, 0.09)))
    even, x = uneven.even, np.linspace(0.0, 0.4, 50)
    assert uneven.reach_mm == even.reach_mm == 0.4
    for side in (1.0, -1.0):
        at = np.column_stack([side * x, np.zeros_like(x)])
        assert (even.height(at) >= uneven.height(at) - 1e-9).all()
    assert even.even == even


@pytest.mark.parametrize(
    ("rows", "pad", "complaint"),
    [
        ("x_um,height_um\nhigh,low\n", "", "profile_file that cannot be taken: .*no table of numbers"),
        ("x_um,z_um\n0,1\n1,0\n2,0\n", "", "has no column height_um$"),
        ("x_um,height_um\n0,1\n1,1\n2,1\n", "", "does not describe a face: a profile that falls nowhere"),
        ("x_um,height_um\n0,3\n2,2\n1,1\n", "", "with x increasing"),
        ("x_um,height_um\n0,3\n1,2\n2,1\n", "profile_points_mm = [[0, 0], [1, 1], [2, 2]]", "give one of the two"),
        ("x_um,height_um\n0,3\n1,2\n2,1\n", "radius_mm = 3", "does not say which face it has: give radius_mm, or"),
        (None, "", r"cannot be taken: .*pad\.csv"),
        (None, "face_half_width_mm = 5\nradius_mm = 4", "no face cut off a radius of 4"),
    ],
)
def test_a_face_that_cannot_be_is_stated_in_words(tmp_path: Path, rows: str | None, pad: str, complaint: str) -> None:
    if rows is not None:
        (tmp_path / "pad.csv").write_text(rows, encoding="utf-8")
    named = "" if "cut off" in complaint else 'profile_file = "pad.csv"\n'
    path = tmp_path / "study.toml"
    path.write_text(LINE.format(pad=named + pad), encoding="utf-8")
    with pytest.raises(StudyError, match=complaint.replace("$", r"\W*$")) as message:
        study_from_tables(read_study(path), str(path))
    assert "\n" not in str(message.value)


def pad(**keys: Any) -> dict[str, Any]:
    """A pad on a flat."""
    upper = {"shape": "pad", **keys, **STEEL}
    return {"kind": "point-contact", "bodies": {"lower": {"shape": "flat", **STEEL}, "upper": upper}}


@pytest.mark.slow
def test_a_turned_arc_and_a_turned_table_of_a_parabola_wear_as_the_ball(tmp_path: Path) -> None:
    x = np.linspace(0.0, 0.5, 101)
    table = [[float(a), float(a**2 / (2.0 * BALL_RADIUS_mm))] for a in x]
    pads = {"arc": pad(radius_mm=BALL_RADIUS_mm), "table": pad(profile_points_mm=table)}
    (ball,) = run_study(study(BALL), fidelity="quick", output=tmp_path / "ball")
    for name, contact in pads.items():
        (run,) = run_study(study(contact), fidelity="quick", output=tmp_path / name)
        for column in ("dissipated_energy_mJ", "max_tangential_force_N", "contact_half_width_um"):
            assert run.evolution[column][-1] == pytest.approx(ball.evolution[column][-1], rel=5e-3), (name, column)
        for body, other in (("upper", "ball"), ("lower", "flat")):
            assert run.scar(20, body).max_depth_um == pytest.approx(ball.scar(20, other).max_depth_um, rel=0.01)


def test_a_turned_arc_touches_as_hertz_says_and_a_turned_rounded_flat_as_ciavarella_does() -> None:
    """J. Strain Anal. 34 (1999) 313: the same sum of flat punches in closed form, of parabolic edges."""
    hertz = reference.hertz_point(50.0, BALL_RADIUS_mm, MODULUS)
    arc = reference.turned_contact(Cylinder(BALL_RADIUS_mm, curved_along=True), 50.0, MODULUS, 1.0)
    for name in ("major_semi_axis_mm", "approach_mm", "peak_pressure_MPa"):
        assert getattr(arc, name) == pytest.approx(getattr(hertz, name), rel=5e-3)
    a, b = 0.5, 0.4
    root, angle = np.sqrt(a**2 - b**2), np.arccos(b / a)
    cubes, squares = root * (2.0 * a**2 + b**2) / 3.0, 0.5 * a**2 * angle + 0.5 * b * root
    closed = 2.0 * MODULUS / R_mm * (cubes - b * squares)
    assert reference.turned_load(RoundedFlat(b, R_mm), a, MODULUS) == pytest.approx(closed, rel=0.01)
    touching = reference.turned_contact(RoundedFlat(b, R_mm), closed, MODULUS, 1.0)
    assert touching.contact_radius_mm == pytest.approx(a, rel=1e-3)
    assert touching.approach_mm == pytest.approx((root * a - b * a * angle) / R_mm, rel=0.01)


@pytest.mark.slow
def test_a_pressed_pin_with_rounded_edges_has_sneddons_radius_approach_and_middle() -> None:
    face, load = RoundedFlat(0.5, 1.0), POINTS["conditions"]["normal_load_N"]
    asked = study(pad(face_half_width_mm=0.5, edge_radius_mm=1.0), wear=None, fidelity={})
    meshes = PointRun.of(asked, "standard").meshes
    problem = meshes.problem(meshes.first(), lambda _: None)
    state, report = press(problem, unloaded_state(problem))
    exact = reference.turned_contact(face, load, STEEL_MODULUS, 1.0)
    body = problem.upper
    pressure, far = state.primary_force[:, 2] / body.patch.node_areas(), np.hypot(*body.node_positions[:, :2].T)
    assert report.half_width_x == pytest.approx(exact.contact_radius_mm, abs=body.patch.smallest_element)
    # A block is stiffer than a half-space.
    assert -state.holder_z == pytest.approx(exact.approach_mm, rel=0.12)
    # In the middle a flat punch has half of its mean pressure.
    assert pressure[far < 1e-6] == pytest.approx(load / (2.0 * np.pi * exact.contact_radius_mm**2), rel=0.05)


@pytest.mark.parametrize(
    ("contact", "complaint"),
    [
        (pad(), r"shape in \[bodies.upper\] of s.toml is \"pad\", whose face is not stated: give radius_mm, or"),
        (pad(radius_mm=3.0, diameter_mm=2.0), "diameter_mm in .* is given, but a pad has no diameter"),
        (pad(profile_points_mm=[[-1, 1], [0, 0], [1, 1]]), "a turned face has points from x = 0 on"),
    ],
)
def test_a_turned_face_that_cannot_be_is_stated_in_one_sentence(contact: dict[str, Any], complaint: str) -> None:
    with pytest.raises(StudyError, match=complaint):
        study(contact)


def test_a_pad_whose_metal_would_flow_is_refused_as_the_study_is_read() -> None:
    with pytest.raises(StudyError, match=r'is "near zone", .* but "upper" is a pad: "limited pressure" takes it\.$'):
        study(pad(radius_mm=3.0) | {"contact": {"friction": 0.6, "plasticity": "near zone"}})


def test_a_pad_stands_on_a_flat_and_no_other_body_has_its_keys() -> None:
    two = pad(radius_mm=3.0)
    two["bodies"]["lower"] = two["bodies"]["upper"]
    with pytest.raises(StudyError, match="a pad is pressed on a flat"):
        study(two)
    foreign = pad(radius_mm=3.0)
    foreign["bodies"]["lower"] = foreign["bodies"]["lower"] | {"edge_radius_mm": 1.0}
    with pytest.raises(StudyError, match=r"edge_radius_mm in .* is of a pad, but a flat has diameters"):
        study(foreign)
    with pytest.raises(StudyError, match=r"the pad is too small for this test: .* does not bear"):
        discretise(study(pad(profile_points_mm=[[0, 0], [0.01, 1e-5], [0.02, 4e-5]])), "quick")
