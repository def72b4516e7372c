"""Metal that flows: hardening in bars, strains of a half-space, and spheres pressed into it."""

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from geometry import Elastic
from geometry.arrays import Array
from solvers.laws.plasticity import Flow, Metal, flown
from solvers.laws.yielding import PressureLimit
from solvers.stress.half_space import HalfSpace
from solvers.stress.pressing import Indentation, indented
from tests.solvers import test_contact_bodies as known
from tests.solvers.test_yielding import MODULUS_MPa, jackson_green, kogut_etsion, limit_at
from wirewear.verification.near_zone import rolled, under_sphere

STEEL = Elastic(200_000.0, 0.3)


def stretched(metal: Metal, strains: list[float], steps: int = 300) -> list[float]:
    """Axial stresses in MPa of a bar at the turning points of its strain."""
    lame, shear = 200_000.0 * 0.3 / 1.3 / 0.4, STEEL.shear_modulus_MPa
    flow, found, last, across = Flow.none(1), [], 0.0, 0.0

    def after(axial: float, lateral: float) -> tuple[Array, Flow]:
        strain = np.array([axial, lateral, lateral, 0.0, 0.0, 0.0])
        stress = 2.0 * shear * strain + lame * (axial + 2.0 * lateral) * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        new = flown(metal, shear, stress[None] - 2.0 * shear * flow.strain, flow)
        return stress - 2.0 * shear * new.strain[0], new

    for goal in strains:
        for axial in np.linspace(last, goal, steps + 1)[1:]:
            other = across - 1e-6
            (stress, new), (side, _) = after(axial, across), after(axial, other)
            while abs(stress[1]) > 1e-8:
                across, other, side = across - stress[1] * (across - other) / (stress[1] - side[1]), across, stress
                stress, new = after(axial, across)
            flow = new
        last = goal
        found.append(float(stress[0]))
    return found


@pytest.mark.parametrize(
    ("metal", "strains", "expected"),
    [
        (Metal(300.0, 10_000.0), [0.006, -0.006, 0.006], [342.857, -342.857, 342.857]),
        (Metal(300.0, 10_000.0, 0.8), [0.006, -0.006, 0.006, -0.006], [342.857, -359.184, 375.199, -390.910]),
        (Metal(300.0, 30_000.0, 1.0, 150.0), [0.006, -0.006] * 4, [406.694, -406.694]),
    ],
    ids=["kinematic", "mixed", "recalling"],
)
def test_a_bar_hardens_as_in_closed_form(metal: Metal, strains: list[float], expected: list[float]) -> None:
    assert stretched(metal, strains)[-len(expected) :] == pytest.approx(expected, rel=1e-3)


def test_a_beam_keeps_the_residual_curvature_and_stress_of_its_closed_form() -> None:
    """Bent by 1.3 times the moment of first yield, 10 mm x 20 mm, 300 MPa: fibres from the axis to the face."""
    share = (np.arange(200) + 0.5) / 200.0
    first = 300.0 / 200_000.0
    stress = np.array([stretched(Metal(300.0), [1.58114 * first * one], 1)[0] for one in share[::20]])
    core = np.minimum(1.58114 * share, 1.0)
    assert stress == pytest.approx(300.0 * core[::20], rel=1e-6)
    moment = 3.0 * (core * share).mean()
    assert moment == pytest.approx(1.3, rel=1e-3)
    assert 1.58114 - moment == pytest.approx(0.28114, abs=5e-3)
    assert (core - moment * share)[[-1, 126]] == pytest.approx([-0.3, 0.1778], abs=5e-3)


def expanded(pressure_MPa: float, shells: int = 40) -> float:
    """Displacement in mm of the inner face of a sphere of 10 and 20 mm radius, perfectly plastic at 250 MPa."""
    r = np.linspace(10.0, 20.0, shells + 1)
    middle, size = 0.5 * (r[1:] + r[:-1]), np.diff(r)
    # Strains rr, tt and tt at the middles by displacements of the shells' faces.
    slope = np.zeros((3, shells, shells + 1))
    for k in range(shells):
        slope[0, k, k : k + 2] = [-1.0 / size[k], 1.0 / size[k]]
        slope[1:, k, k : k + 2] = 0.5 / middle[k]
    volume, shear = middle**2 * size, STEEL.shear_modulus_MPa
    law = 2.0 * shear * np.eye(3) + 2.0 * shear * 0.3 / 0.4
    stiffness = np.einsum("akn,ab,bkm,k->nm", slope, law, slope, volume)
    flow, moved = Flow.none(shells), np.zeros(shells + 1)
    for pressure in np.linspace(0.0, pressure_MPa, 21)[1:]:
        for _ in range(400):
            strain = np.einsum("akn,n->ka", slope, moved)
            trial = np.zeros((shells, 6))
            trial[:, :3] = strain @ law - 2.0 * shear * flow.strain[:, :3]
            new = flown(Metal(250.0), shear, trial, flow)
            stress = strain @ law - 2.0 * shear * new.strain[:, :3]
            left = -np.einsum("akn,ka,k->n", slope, stress, volume)
            left[0] += pressure * r[0] ** 2
            if np.abs(left).max() < 1e-5 * pressure * r[0] ** 2:
                break
            moved += np.linalg.solve(stiffness, left)
        flow = new
    return float(moved[0])


@pytest.mark.parametrize(("pressure_MPa", "moved_mm"), [(221.827, 0.0106835), (299.087, 0.0235495)])
def test_a_thick_sphere_expands_as_in_closed_form(pressure_MPa: float, moved_mm: float) -> None:
    assert expanded(pressure_MPa) == pytest.approx(moved_mm, rel=5e-3)


def space(shape: tuple[int, int] = (63, 63)) -> HalfSpace:
    """Six points to a contact of 1 mm radius."""
    return HalfSpace(STEEL, shape, (1.0 / 6.0, 1.0 / 6.0), np.asarray(0.06 * 1.1 ** np.arange(20), dtype=np.float64))


def test_stresses_beneath_hertz_pressure_are_those_of_closed_form() -> None:
    own = space()
    x, y = own.axes_mm()
    pressure = np.sqrt(np.maximum(1.0 - x[:, None] ** 2 - y**2, 0.0))
    traction = np.stack([0.0 * pressure, 0.0 * pressure, -pressure], axis=-1)
    stress, z = own.stresses(own.moved(traction, None)[0])[:, 31, 31], own.depths_mm
    radial = 0.5 / (1.0 + z**2) - 1.3 * (1.0 - z * np.arctan(1.0 / z))
    assert stress[:, 2] == pytest.approx(-1.0 / (1.0 + z**2), abs=2e-3)
    # Whose images, ten radii away, press as well.
    assert stress[:, 0] == pytest.approx(radial, abs=0.015)
    assert stress[:, 1] == pytest.approx(radial, abs=0.015)


@pytest.mark.parametrize("shape", [(15, 15), (15, 1)])
def test_displacements_by_initial_strains_and_by_tractions_are_reciprocal(shape: tuple[int, int]) -> None:
    """Betti: the work of tractions on displacements by initial stresses is that of these on strains by the former."""
    own, random = space(shape), np.random.default_rng(3)
    traction, initial = random.normal(size=(*shape, 3)), random.normal(size=(20, *shape, 6))
    traction -= traction.mean(axis=(0, 1))
    initial -= initial.mean(axis=(1, 2), keepdims=True)
    (strain, _), (_, moved) = own.moved(traction, None), own.moved(None, initial)
    twice = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
    work = np.einsum("lxyc,lxyc,c,l->", initial, strain, twice, own.layers_mm)
    assert (traction * moved).sum() == pytest.approx(work, rel=1e-9)


def test_metal_that_may_not_spread_between_layers_of_strain_leaves_its_thickness_on_the_surface() -> None:
    """A strain that is alike in the whole of a layer, with no room aside, raises all above it."""
    own, initial = space((5, 5)), np.zeros((20, 5, 5, 6))
    initial[3] = 2.0 * STEEL.shear_modulus_MPa * np.array([0.5e-3, 0.5e-3, -1e-3, 0.0, 0.0, 0.0])
    strain, _ = own.moved(None, initial)
    ratio = 2.0 * STEEL.shear_modulus_MPa / (own.elastic[0] + 2.0 * STEEL.shear_modulus_MPa)
    assert strain[3, 2, 2, 2] == pytest.approx(-1e-3 * ratio, rel=1e-6)
    assert np.abs(strain[[2, 4]]).max() < 1e-9


def sphere_at(beyond: float, points: int = 4) -> tuple[PressureLimit, Indentation]:
    """What a perfectly plastic body at so many times the load of first yield carries, and its state under a sphere."""
    limit = limit_at(beyond)
    contact = (0.75 * known.LOAD_N * known.RADIUS_mm / MODULUS_MPa) ** (1.0 / 3.0) * beyond**0.08
    material = Elastic(MODULUS_MPa * (1.0 - 0.3**2), 0.3)
    zone, gap = under_sphere(known.RADIUS_mm, material, Metal(limit.yield_stress_MPa), contact, points)
    with threadpool_limits(limits=1, user_api="blas"):
        *_, last = indented(zone, gap, known.LOAD_N * np.linspace(0.1, 1.0, 10) ** 2)
    return limit, last


@pytest.mark.seconds
@pytest.mark.parametrize(("beyond", "residual"), [(4.1, 0.14), (8.7, 0.23), (458.0, 0.72)])
def test_metal_that_flows_keeps_of_its_penetration_the_part_that_finite_elements_leave(
    beyond: float, residual: float
) -> None:
    limit, last = sphere_at(beyond)
    assert jackson_green(limit, last.approach_mm) == pytest.approx(known.LOAD_N, rel=0.05)
    assert last.print_mm / last.approach_mm == pytest.approx(residual, rel=0.12, abs=0.01)
    assert last.pressure_MPa.sum() * (last.area_mm2 / (last.pressure_MPa > 0.0).sum()) == pytest.approx(
        known.LOAD_N, rel=1e-9
    )


@pytest.mark.slow
@pytest.mark.parametrize("beyond", [1.05, 1.5, 2.5, 4.1, 8.7, 16.0, 27.0, 58.0, 110.0, 210.0, 458.0])
def test_metal_that_flows_bears_what_published_curves_say(beyond: float) -> None:
    """Penetrations of 1 to 100 times that of first yield; 4 points to a radius miss one by 6 %."""
    limit, last = sphere_at(beyond, 6)
    assert jackson_green(limit, last.approach_mm) == pytest.approx(known.LOAD_N, rel=0.05)
    assert kogut_etsion(limit, last.approach_mm) == pytest.approx(known.LOAD_N, rel=0.05)


@pytest.mark.seconds
def test_pressed_again_metal_is_elastic_and_work_is_stored_or_plastic() -> None:
    limit = limit_at(8.7)
    contact = (0.75 * known.LOAD_N * known.RADIUS_mm / MODULUS_MPa) ** (1.0 / 3.0) * 1.1
    material = Elastic(MODULUS_MPa * (1.0 - 0.3**2), 0.3)
    zone, gap = under_sphere(known.RADIUS_mm, material, Metal(limit.yield_stress_MPa), contact, 4)
    rising = np.linspace(0.04, 1.0, 20) ** 2
    loads = known.LOAD_N * np.concatenate([rising, rising[-2::-1], np.tile([1.0, rising[0]], 4)])
    with threadpool_limits(limits=1, user_api="blas"):
        course = list(indented(zone, gap, loads))
    pressed, last = course[19].state.flow.accumulated, course[-1].state
    assert np.abs(last.flow.accumulated - pressed).max() < 5e-3 * pressed.max()
    work = np.trapezoid([0.0] + [one.load_N for one in course], [0.0] + [one.approach_mm for one in course])
    volumes = np.repeat(zone.space.layers_mm * np.prod(zone.space.step_mm), gap.size)
    plastic = limit.yield_stress_MPa * float(last.flow.accumulated @ volumes)
    stress = last.stress.reshape(-1, 6)
    square = stress**2 @ np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
    stored = 0.5 / material.youngs_modulus_MPa * (1.3 * square - 0.3 * stress[:, :3].sum(axis=1) ** 2)
    assert work == pytest.approx(plastic + float(stored @ volumes), rel=5e-3)


@pytest.mark.seconds
def test_a_rolling_line_leaves_the_residual_stress_of_merwin_and_johnson_and_shakes_down_below_melans_limit() -> None:
    first, _ = next(rolled(3.9, 0.0))
    assert first == pytest.approx(-0.497, rel=0.1)
    below, above = ([flow for _, flow in rolled(share * 4.0, 0.0, 3)] for share in (0.95, 1.05))
    assert below[-1] < 1e-3 * below[0]
    assert above[-1] > 0.3 * above[0]
