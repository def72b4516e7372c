"""Laws of pressure and of distance as integrals over elements, against those over the ellipse of Hertz."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import minimum_filter

from geometry import ContactPatch, Flat
from geometry.arrays import Array
from solvers import Archard, Coulomb, Friction, OxygenDistance, PowerOfPressure, ShearLimited
from solvers.contact.between_nodes import SpreadPressure, WithinElements
from solvers.contact.linearising import sliding_force
from solvers.laws.friction_law import FrictionLaw
from tests.bodies import FRICTION, LOAD_N, STEEL, RADIUS_mm, crossed_wires, pressed
from wirewear.reference import Elastic, PointContact, contact_modulus, hertz_point
from wirewear.simulation.expected_contact import law_error

P0_MPa = 1000.0
RADII = np.linspace(0.0, 1.0, 20_001)


def over_ellipse(values: Callable[[Array], Array], minor_mm: float, major_mm: float) -> float:
    """Integral of a function of the pressure P0 √(1 − ρ²)."""
    found = np.trapezoid(values(P0_MPa * np.sqrt(1.0 - RADII**2)) * RADII, RADII)
    return float(2.0 * np.pi * minor_mm * major_mm * found)


def hertz_patch(elements: float, ratio: float = 1.0, shift: float = 0.0) -> tuple[ContactPatch, Array]:
    """A patch with so many elements over the minor semi-axis of 1 mm, and an ellipse's pressure at its nodes, where the
    outermost carry what is left of the load: so do those of a contact in equilibrium.
    """
    along, across = (np.arange(-12, 13) / elements * extent + shift / elements for extent in (ratio, 1.0))
    patch = ContactPatch(along, across, np.arange(625).reshape(25, 25), Flat())
    x, y = np.meshgrid(along, across, indexing="ij")
    pressure = P0_MPa * np.sqrt(np.maximum(1.0 - (x / ratio) ** 2 - y**2, 0.0))
    rim = (pressure > 0.0) & (minimum_filter(pressure, 3) == 0.0)
    loads = patch.node_areas().reshape(pressure.shape) * pressure
    pressure[rim] *= 1.0 + (2.0 / 3.0 * np.pi * ratio * P0_MPa - loads.sum()) / loads[rim].sum()
    return patch, pressure.ravel()


@pytest.mark.parametrize("law", [ShearLimited(100.0), ShearLimited(1000.0), PowerOfPressure(500.0, 2.0 / 3.0)])
@pytest.mark.parametrize(("elements", "ratio", "shift"), [(3.5, 1.0, 0.0), (3.5, 4.0, 0.3), (7.0, 1.0, 0.5)])
def test_a_law_over_elements_is_its_integral_over_the_ellipse(
    law: FrictionLaw, elements: float, ratio: float, shift: float
) -> None:
    spread = SpreadPressure.of(*hertz_patch(elements, ratio, shift))
    assert spread.area_mm2 == pytest.approx(np.pi * ratio, rel=0.02)
    exact = over_ellipse(lambda pressure: law.limit(0.5, pressure), 1.0, ratio)
    assert spread.integrals(Friction(0.5, law))[0] == pytest.approx(exact, rel=0.01)


@pytest.mark.parametrize("reach", [0.2, 0.5, 0.8, 5.0])
@pytest.mark.parametrize(("elements", "shift"), [(3.5, 0.0), (3.5, 0.4), (8.0, 0.2)])
def test_distances_are_those_from_the_contacts_edge_and_not_from_open_nodes(
    elements: float, shift: float, reach: float
) -> None:
    patch, pressure = hertz_patch(elements, shift=shift)
    spread = SpreadPressure.of(patch, pressure)
    factor = spread.averaged(np.where(spread.edge_distance_mm <= reach, 1.0, 0.1), 1.0)
    load = patch.node_areas() * pressure
    weight = np.sqrt(1.0 - RADII**2) * RADII
    exact = np.trapezoid(np.where(reach >= 1.0 - RADII, 1.0, 0.1) * weight, RADII) / np.trapezoid(weight, RADII)
    assert load @ factor / load.sum() == pytest.approx(exact, rel=0.03)
    assert spread.averaged(np.full(len(spread.pressure_MPa), 0.7), 0.7) == pytest.approx(0.7)


def test_coulombs_law_is_its_nodes_pressures_and_all_is_none_where_nothing_is_pressed() -> None:
    patch, pressure = hertz_patch(3.5)
    within = WithinElements(patch, [pressure], np.zeros(5, dtype=int))
    assert Friction(0.5, Coulomb(), within).share == 1.0
    bent = Friction(0.5, ShearLimited(300.0), within).among(slice(0, 2))
    assert bent.share == pytest.approx(np.ones(2), abs=0.2)
    empty = SpreadPressure.of(patch, np.zeros(patch.size))
    assert (empty.area_mm2, len(empty.edge_distance_mm)) == (0.0, 0)
    assert empty.share(Friction(0.5, ShearLimited(300.0))) == 1.0


def limited_shear_N(hertz: PointContact, strength_MPa: float) -> float:
    """Integral of k (1 - exp(-mu p / k)) over the pressure p0 sqrt(1 - r²/a²)."""
    beta = FRICTION * hertz.peak_pressure_MPa / strength_MPa
    share = 0.5 - (1.0 - (1.0 + beta) * np.exp(-beta)) / beta**2
    return float(2.0 * np.pi * hertz.major_semi_axis_mm**2 * strength_MPa * share)


@pytest.mark.seconds
@pytest.mark.parametrize("relative_load", [0.6, 0.8, 1.1, 1.5])
def test_where_the_contacts_edge_falls_between_nodes_does_not_show_in_saturated_friction(relative_load: float) -> None:
    steel = Elastic(STEEL.youngs_modulus_MPa, STEEL.poissons_ratio)
    hertz = hertz_point(LOAD_N * relative_load, RADIUS_mm, contact_modulus(steel, steel))
    problem = replace(crossed_wires(0.0143 / 3.75), friction_law=ShearLimited(60.0))
    problem = replace(problem, holder=replace(problem.holder, normal_load_N=LOAD_N * relative_load))
    assert sliding_force(problem, pressed(problem)[0]) == pytest.approx(limited_shear_N(hertz, 60.0), rel=0.02)


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize("strength_MPa", [500.0, 1000.0, 4000.0])
@pytest.mark.parametrize(("elements", "tolerance"), [(2.4, 0.05), (3.5, 0.02)])
def test_a_sliding_contact_of_limited_shear_carries_the_laws_integral(
    strength_MPa: float, elements: float, tolerance: float
) -> None:
    steel = Elastic(STEEL.youngs_modulus_MPa, STEEL.poissons_ratio)
    hertz = hertz_point(LOAD_N, RADIUS_mm, contact_modulus(steel, steel))
    problem = replace(crossed_wires(hertz.minor_semi_axis_mm / elements), friction_law=ShearLimited(strength_MPa))
    exact = limited_shear_N(hertz, strength_MPa)
    state = pressed(problem)[0]
    assert sliding_force(problem, state) == pytest.approx(exact, rel=tolerance)
    assert abs(sliding_force(problem, state) / exact - 1.0) < law_error(problem, state) < 0.05


def test_every_law_but_coulombs_has_an_error_that_falls_with_the_elements() -> None:
    errors = []
    for elements in (2.0, 4.0):
        problem = crossed_wires(0.0143 / elements)
        state = pressed(problem)[0]
        worn = replace(problem, wear=replace(problem.wear, upper_mm3_per_mJ=1e-8))
        assert np.isnan(law_error(problem, state))
        assert np.isnan(law_error(replace(worn, wear=replace(worn.wear, law=Archard())), state))
        starved = replace(worn, wear=replace(worn.wear, law=OxygenDistance(0.1, distance_mm=0.01)))
        errors.append([law_error(one, state) for one in (replace(problem, friction_law=ShearLimited(500.0)), starved)])
    assert (np.array(errors[1]) < np.array(errors[0])).all()
    assert (np.array(errors[1]) > 0.0).all()
