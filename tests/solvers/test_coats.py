"""Layers of other materials: compliance of a coated half-space and indentation by a ball, against other principles."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import jv

from geometry import ContactPatch, Elastic, Flat, GradedAxis, Layering
from geometry.arrays import Array
from solvers import Coating, ContactProblem, coated, facing, place, press, recoated, unloaded_state
from solvers.elasticity.coats import CoatedPatch
from solvers.elasticity.patch_compliance import PatchCompliance
from solvers.stress.coats import SIDE, CoatStress, _waves, across_interface
from tests.simulation.point_contacts import LOAD_N, TEST, RADIUS_mm
from tests.studies import line_study
from wirewear.simulation.line_model import bodies, line_plan, line_problem
from wirewear.simulation.point_runs import PointRun
from wirewear.simulation.problem import condensed_body, laws_of
from wirewear.test import Study, study_from_tables

STEEL = Elastic(210000.0, 0.3)
#: Of steel on steel.
HERTZ_mm = (0.75 * LOAD_N * RADIUS_mm * 2.0 * 0.91 / 210000.0) ** (1.0 / 3.0)


def burmister(k: Array, thickness_mm: float, layer: Elastic, below: Elastic) -> Array:
    """Normal displacement in mm/MPa under waves of pressure of numbers k (n,): the closed form for one layer, as
    O'Sullivan & King (J. Tribol. 110 (1988) 235) give it.
    """
    (e1, n1), (e2, n2) = ((one.youngs_modulus_MPa, one.poissons_ratio) for one in (layer, below))
    ratio = e1 / (1.0 + n1) / (e2 / (1.0 + n2))
    lam, kappa = 1.0 - 4.0 * (1.0 - n1) / (1.0 + ratio * (3.0 - 4.0 * n2)), (ratio - 1.0) / (ratio + 3.0 - 4.0 * n1)
    a = k * thickness_mm
    e = np.exp(-2.0 * a)
    over, under = 1.0 + 4.0 * a * kappa * e - lam * kappa * e**2, 1.0 - (lam + kappa + 4.0 * kappa * a**2) * e
    return np.asarray(2.0 * (1.0 - n1**2) / e1 / k * over / (under + lam * kappa * e**2))


@pytest.mark.parametrize("layer", [Elastic(52500.0, 0.3), Elastic(840000.0, 0.2), Elastic(3000.0, 0.45)])
def test_waves_of_pressure_press_a_coated_half_space_in_as_burmister_says(layer: Elastic) -> None:
    k = np.geomspace(1e-2, 1e4, 60)
    plane, _ = Coating(((0.01, layer),), STEEL).softening(k)
    found = plane[:, 1, 1] + 2.0 * 0.91 / 210000.0 / k
    np.testing.assert_allclose(found, burmister(k, 0.01, layer, STEEL), rtol=1e-6)
    np.testing.assert_allclose(plane[:, 0, 1], plane[:, 1, 0], rtol=1e-6, atol=1e-12)


def test_layers_of_the_bodys_own_material_change_nothing_and_two_of_one_material_are_one() -> None:
    k = np.geomspace(1e-2, 1e4, 60)
    for found in Coating(((0.01, STEEL), (0.1, STEEL)), STEEL).softening(k):
        assert np.abs(found).max() < 1e-13
    soft = Elastic(60000.0, 0.25)
    for two, one in zip(
        Coating(((0.01, soft), (0.02, soft)), STEEL).softening(k),
        Coating(((0.03, soft),), STEEL).softening(k),
        strict=True,
    ):
        np.testing.assert_allclose(two, one, rtol=1e-6, atol=1e-14)


def lines(count: int, first: float, growth: float) -> Array:
    half = np.cumsum(np.append(0.0, first * growth ** np.arange(count)))
    return np.concatenate([-half[:0:-1], half])


def added(coating: Coating, planes: tuple[int, ...], left: float = 1.0) -> Array:
    along, across = lines(6, 0.01, 1.1), lines(5, 0.02, 1.15)
    shape = len(along), len(across)
    patch = ContactPatch(along, across, np.arange(shape[0] * shape[1]).reshape(shape), Flat())
    q = int(np.prod([(n + 1) // 2 if axis in planes else n for axis, n in enumerate(shape)]))
    bare = PatchCompliance(shape, planes, np.zeros((2 ** len(planes), 3 * q, 3 * q)))
    of_patch = CoatedPatch(patch, bare, (coating, None))
    worn = np.full(patch.size, (1.0 - left) * coating.thickness_mm)
    return of_patch.compliance(of_patch.left_mm(worn, worn)).dense


def test_a_quarter_and_its_images_answer_as_the_whole_patch() -> None:
    coating = Coating(((0.02, Elastic(60000.0, 0.25)),), STEEL)
    whole = added(coating, ())
    for planes in ((0,), (1,), (0, 1)):
        np.testing.assert_allclose(added(coating, planes), whole, atol=1e-10 * np.abs(whole).max())
    np.testing.assert_allclose(whole, whole.T, atol=1e-10 * np.abs(whole).max())
    assert np.abs(added(coating, (), left=0.0)).max() == 0.0


def test_nodes_beneath_a_very_thick_layer_answer_as_on_a_half_space_of_its_material() -> None:
    soft = Elastic(105000.0, 0.25)
    found, middle = added(Coating(((50.0, soft),), STEEL), ()), 6 * 11 + 5
    # Between cells of 0.01 × 0.021 mm whose middles lie (0.011, 0.0215) mm apart: mean of the point solution.
    x, w = np.polynomial.legendre.leggauss(24)
    along, across = lines(6, 0.01, 1.1), lines(5, 0.02, 1.15)

    def cell(values: Array, k: int) -> Array:
        low, high = 0.5 * (values[k - 1] + values[k]), 0.5 * (values[k] + values[k + 1])
        return np.asarray(low + 0.5 * (high - low) * (1.0 + x))

    dx = cell(along, 6)[:, None, None, None] - cell(along, 7)[None, :, None, None]
    dy = cell(across, 5)[None, None, :, None] - cell(across, 6)
    weight = np.einsum("i,j,k,l->ijkl", *[0.5 * w] * 4)
    r = np.hypot(dx, dy)
    block = found[3 * middle : 3 * middle + 3, 3 * (middle + 12) : 3 * (middle + 12) + 3]

    def mean(kernel: Callable[[float], Array]) -> float:
        of = [
            (1.0 + one.poissons_ratio)
            / (np.pi * one.youngs_modulus_MPa)
            * float((weight * kernel(one.poissons_ratio)).sum())
            for one in (soft, STEEL)
        ]
        return of[0] - of[1]

    normal = mean(lambda nu: (1.0 - nu) / r)
    sideways = mean(lambda nu: (1.0 - nu + nu * dx**2 / r**2) / r)
    coupled = mean(lambda nu: -0.5 * (1.0 - 2.0 * nu) * dx / r**2)
    assert block[2, 2] == pytest.approx(normal, rel=5e-3)
    assert block[0, 0] == pytest.approx(sideways, rel=5e-3)
    assert block[2, 0] == pytest.approx(coupled, rel=5e-3)
    assert block[0, 2] == pytest.approx(-coupled, rel=5e-3)


def indented(radius_mm: float, thickness_mm: float, layer: Elastic) -> tuple[float, float, float]:
    """(contact radius in mm, approach in mm, largest pressure in MPa) of a steel ball of this radius on coated steel
    under LOAD_N: Fredholm's equation of the second kind for the pressure's transform (Sneddon, Fourier Transforms,
    1951), with Burmister's closed form and no elements.
    """
    of_ball = 0.91 / 210000.0
    x, w = np.polynomial.legendre.leggauss(300)
    k, wk = 10.0 / thickness_mm * (x + 1.0), 10.0 / thickness_mm * w
    # The response over that of the layer's own half-space decays at large k.
    top = 1.0 / ((1.0 - layer.poissons_ratio**2) / layer.youngs_modulus_MPa + of_ball)
    excess = top * (0.5 * k * burmister(k, thickness_mm, layer, STEEL) + of_ball) - 1.0

    def found(a: float) -> tuple[float, float, float]:
        t, wt = np.polynomial.legendre.leggauss(60)
        t, wt = 0.5 * a * (t + 1.0), 0.5 * a * wt
        waves = np.cos(np.outer(t, k))
        matrix = np.eye(len(t)) + 2.0 / np.pi * (waves * wk * excess) @ waves.T * wt
        flat, round_ = (np.linalg.solve(matrix, top / np.pi * of) for of in (np.ones_like(t), t**2 / radius_mm))
        edge = 2.0 / np.pi * (np.cos(a * k) * wk * excess) @ waves.T * wt
        approach = (top / np.pi * a**2 / radius_mm - edge @ round_) / (top / np.pi - edge @ flat)
        phi = approach * flat - round_
        slope = np.polynomial.Chebyshev.fit((t / a) ** 2, phi, 14, domain=[0.0, 1.0]).deriv()
        return 2.0 * np.pi * float(wt @ phi), float(approach), float(-wt @ slope((t / a) ** 2) * 2.0 / a**2)

    a = float(brentq(lambda one: found(one)[0] - LOAD_N, 0.5 * HERTZ_mm, 2.0 * HERTZ_mm))
    return a, found(a)[1], found(a)[2]


@cache
def ball_on_flat() -> Study:
    own = {"youngs_modulus_MPa": STEEL.youngs_modulus_MPa, "poissons_ratio": STEEL.poissons_ratio}
    both = {"ball": {"diameter_mm": 2.0 * RADIUS_mm, **own}, "flat": own}
    found: Study = study_from_tables(
        {**TEST, "kind": "ball-on-flat", "bodies": both, "contact": {"friction": 0.0}, "wear": None}, "s.toml"
    )
    return found


def pressed(layer: Elastic | None, thickness_mm: float, on: str, worn_mm: float = 0.0) -> tuple[float, float, float]:
    """(contact radius, approach, largest pressure) of the bodies in elements, four a contact radius."""
    study, axis = ball_on_flat(), GradedAxis(0.25 * HERTZ_mm, 1.7 * HERTZ_mm, 0.25 * HERTZ_mm, 1.75 * HERTZ_mm)
    flat, ball = (condensed_body(body.geometry(axis, axis, Layering.resolving(4.0)), STEEL) for body in study.bodies)
    lower, upper = place(flat, upper=False, axis_angle_rad=0.0), place(ball, upper=True, axis_angle_rad=0.0)
    own = None if layer is None else Coating(((thickness_mm, layer),), STEEL)
    primary = coated(facing(upper, lower), own if on == "ball" else None, own if on == "flat" else None)
    problem = ContactProblem(primary, lower, **laws_of(study))
    state = unloaded_state(problem)
    if worn_mm:
        state.wear.primary_depth[:] = state.wear.secondary_depth[:] = worn_mm
        problem = recoated(problem, state.wear)
        state = unloaded_state(problem)
    state, report = press(problem, state)
    pressure = float(np.abs(state.traction[:, 2]).max())
    return (report.contact_area / np.pi) ** 0.5, -state.holder_z, pressure


CASES = [(0.25, 0.1), (0.25, 2.0), (4.0, 0.3), (0.5, 1.0), (2.0, 1.0), (0.25, 0.3), (4.0, 0.1), (4.0, 2.0)]


@pytest.mark.first_case
@pytest.mark.parametrize(("stiffness", "thick"), CASES)
@pytest.mark.parametrize("on", ["flat", "ball"])
def test_a_ball_on_a_coat_presses_as_without_elements(stiffness: float, thick: float, on: str) -> None:
    layer, thickness = Elastic(stiffness * STEEL.youngs_modulus_MPa, 0.3), thick * HERTZ_mm
    radius, approach, pressure = pressed(layer, thickness, on)
    exact = indented(RADIUS_mm, thickness, layer)
    # What the bodies' own size and the elements change, they change without a coat as well.
    _, bare, _ = pressed(None, 0.0, on)
    hertz = HERTZ_mm**2 / RADIUS_mm
    assert pressure == pytest.approx(exact[2], rel=0.03)
    assert approach - bare == pytest.approx(exact[1] - hertz, abs=0.01 * exact[1])
    # The contact's edge falls between nodes that are a quarter of its radius apart.
    assert radius == pytest.approx(exact[0], rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize(("stiffness", "thick"), [(0.25, 0.1), (4.0, 1.0)])
def test_the_first_mesh_of_a_quick_run_holds_the_contact_on_a_coat(stiffness: float, thick: float) -> None:
    modulus, thickness = stiffness * STEEL.youngs_modulus_MPa, thick * HERTZ_mm
    layer = {"thickness_um": 1e3 * thickness, "youngs_modulus_MPa": modulus}
    study = ball_on_flat().with_values({"bodies.flat.layers": [layer], "wear.energy_wear_coefficient_mm3_per_J": 1e-5})
    meshes = PointRun.of(study, "quick").meshes
    problem = meshes.problem(meshes.first(), lambda _: None)
    _, report = press(problem, unloaded_state(problem))
    radius, _, pressure = indented(RADIUS_mm, thickness, Elastic(modulus, STEEL.poissons_ratio))
    assert report.max_pressure == pytest.approx(pressure, rel=0.03)
    assert (report.contact_area / np.pi) ** 0.5 == pytest.approx(radius, rel=0.03)


LINE_N_per_mm, CYLINDER_mm = 30.0, 6.0
LINE_mm = (4.0 * LINE_N_per_mm * CYLINDER_mm * 2.0 * 0.91 / 210000.0 / np.pi) ** 0.5


def laid(thickness_mm: float, layer: Elastic) -> tuple[float, float]:
    """(half-width in mm, largest pressure in MPa) of a steel cylinder on coated steel: pressures √(1 − s²) U₂ⱼ(s) on
    the layer's own half-plane (Johnson, 1985, section 2.7), and by Burmister's waves what lies below changes of slopes.
    """
    of_ball, of_layer = 0.91 / 210000.0, (1.0 - layer.poissons_ratio**2) / layer.youngs_modulus_MPa
    x, w = np.polynomial.legendre.leggauss(400)
    k, wk = 10.0 / thickness_mm * (x + 1.0), 10.0 / thickness_mm * w
    below = burmister(k, thickness_mm, layer, STEEL) - 2.0 * of_layer / k
    count = 24
    j, angle = np.arange(count), (np.arange(1, count + 1) - 0.5) * np.pi / (2 * count)
    order, sign = 2 * j + 1, (-1.0) ** j

    def found(a: float) -> tuple[float, float]:
        waves = np.pi * sign * order * jv(order, a * k[:, None]) / k[:, None]
        slopes = 2.0 * (of_ball + of_layer) * np.cos(order * angle[:, None])
        slopes += np.sin(np.outer(a * np.cos(angle), k)) * (wk * k * below) / np.pi @ waves
        size = np.linalg.solve(slopes, a * np.cos(angle) / CYLINDER_mm)
        return 0.5 * np.pi * a * float(size[0]), float(size @ sign)

    a = float(brentq(lambda one: found(one)[0] - LINE_N_per_mm, 0.3 * LINE_mm, 3.0 * LINE_mm))
    return a, found(a)[1]


@pytest.mark.first_case
@pytest.mark.parametrize(("stiffness", "thick"), [(0.25, 0.3), (0.5, 0.1), (2.0, 1.0), (4.0, 0.3), (4.0, 2.0)])
def test_a_cylinder_on_a_coat_presses_as_on_a_layered_half_plane(stiffness: float, thick: float) -> None:
    modulus, thickness = stiffness * STEEL.youngs_modulus_MPa, thick * LINE_mm
    own = {"youngs_modulus_MPa": STEEL.youngs_modulus_MPa, "poissons_ratio": STEEL.poissons_ratio}
    study = line_study(
        pad={**own, "radius_mm": CYLINDER_mm},
        specimen={**own, "layers": [{"thickness_um": 1e3 * thickness, "youngs_modulus_MPa": modulus}]},
        conditions={"normal_load_N_per_mm": LINE_N_per_mm},
        wear=None, contact={"friction": 0.0}, mesh={"contact_mesh_um": 125.0 * LINE_mm},
    )  # fmt: skip
    problem = line_problem(study, *bodies(study, line_plan(study, "quick")))
    _, report = press(problem, unloaded_state(problem))
    half, pressure = laid(thickness, Elastic(modulus, STEEL.poissons_ratio))
    assert report.max_pressure == pytest.approx(pressure, rel=0.01)
    assert report.half_width_x == pytest.approx(half, rel=0.04)
    assert report.contact_area == pytest.approx(2.0 * report.half_width_x)


def test_a_coat_that_is_worn_away_is_none() -> None:
    soft = Elastic(52500.0, 0.3)
    assert pressed(soft, 0.02, "flat", worn_mm=0.03) == pytest.approx(pressed(None, 0.0, "flat"), rel=1e-9)


def under_hertz(coating: Coating, depths_mm: Array, places_mm: Array) -> Array:
    """Change of stresses (n, 6) by a coating under Hertz's pressure of unit size and radius 0.1 mm, sheared by half."""
    line = np.linspace(-0.15, 0.15, 61)
    patch = ContactPatch(line, line, np.arange(61 * 61).reshape(61, 61), Flat())
    pressure = np.sqrt(np.maximum(1.0 - (patch.grid() ** 2).sum(axis=1) / 0.01, 0.0)).reshape(61, 61)
    traction = np.stack([0.5 * pressure, 0.0 * pressure, -pressure], axis=-1)
    return CoatStress(coating, patch, traction).at(places_mm, depths_mm)


@pytest.mark.parametrize("layer", [Elastic(52500.0, 0.25), Elastic(840000.0, 0.2)])
def test_tractions_pass_an_interface_and_stresses_in_its_plane_jump_by_equal_strains(layer: Elastic) -> None:
    coating, places = Coating(((0.02, layer),), STEEL), np.array([[0.0, 0.0], [0.05, 0.02], [-0.09, 0.0]])
    k, depths = np.geomspace(1.0, 500.0, 40), 0.02 * np.array([1.0 - SIDE, 1.0 + SIDE])
    (above, below), pure = _waves(coating, k, depths), np.eye(3)
    for force in pure:
        sides = []
        for stress in (above @ force, below @ force):
            ez, zz, ee, tt, tz, et = stress.T
            sides.append(np.stack([ee, tt, zz, et, tz, ez], axis=-1))
        np.testing.assert_allclose(across_interface(sides[1], STEEL, layer), sides[0], atol=1e-6)
    change = [under_hertz(coating, np.full(3, depth), places) for depth in depths]
    np.testing.assert_allclose(change[0][:, [2, 4, 5]], change[1][:, [2, 4, 5]], atol=1e-6)
    assert np.abs(under_hertz(coating, np.zeros(3), places)[:, [2, 4, 5]]).max() < 1e-6


def test_waves_decay_in_a_half_space_as_in_closed_form() -> None:
    k, depth = np.geomspace(1.0, 200.0, 20), 0.03
    (found,) = _waves(Coating((), STEEL), k, np.array([depth]))
    decay, sinks = np.exp(-k * depth), k * depth
    # Johnson, Contact Mechanics, 1985, section 13.2: under p cos(k x) the stresses are p (1 ± k z) exp(-k z) cos(k x).
    np.testing.assert_allclose(found[:, 1, 1], (1.0 + sinks) * decay, atol=1e-12)
    np.testing.assert_allclose(found[:, 2, 1], (1.0 - sinks) * decay, atol=1e-12)
