"""The shape at which wear under partial slip ends, against elasticity integrated by itself."""

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import ellipk

from wirewear.reference import Elastic, LimitingShape, WearingContact, contact_modulus, tangential_contact_modulus

STEEL = Elastic(210_000.0, 0.3)
MODULUS = contact_modulus(STEEL, STEEL)
SHEAR = tangential_contact_modulus(STEEL, STEEL)
#: Steel wires of 0.45 mm crossed at right angles, moved by ±0.39 µm where they touch.
WIRES = WearingContact(0.225, MODULUS, SHEAR, friction=0.62, drive_mm=0.39e-3)
SHAPE = LimitingShape(0.225, approach_mm=0.909e-3, stick_radius_mm=9.37e-3)


def displacement(shape: LimitingShape, radius_mm: float) -> float:
    """Displacement of both half-spaces' surfaces under the shape's pressure, by Boussinesq's solution over rings."""

    def ring(angle: float) -> float:
        # s = c sin(angle) takes the singularity at the edge away.
        s = shape.stick_radius_mm * np.sin(angle)
        pressure = float(shape.pressure(s, MODULUS)) * shape.stick_radius_mm * np.cos(angle)
        return float(pressure * s / (radius_mm + s) * ellipk(4.0 * radius_mm * s / (radius_mm + s) ** 2))

    integral, _ = quad(ring, 0.0, 0.5 * pi * (1.0 - 1e-12), epsrel=1e-9)
    return 4.0 / (pi * MODULUS) * float(integral)


@pytest.mark.parametrize("radius_mm", [0.0095, 0.011, 0.0125, 0.0145, 0.0165])
def test_the_worn_annulus_just_touches(radius_mm: float) -> None:
    gap = displacement(SHAPE, radius_mm) + 0.5 * radius_mm**2 / SHAPE.sphere_radius_mm - SHAPE.approach_mm
    assert gap + SHAPE.depth(radius_mm) == pytest.approx(0.0, abs=1e-8 * SHAPE.approach_mm)
    assert SHAPE.depth(radius_mm) > 0.0


def test_the_stuck_centre_carries_the_load() -> None:
    def ring(angle: float) -> float:
        s = SHAPE.stick_radius_mm * np.sin(angle)
        return float(2.0 * pi * s * SHAPE.pressure(s, MODULUS) * SHAPE.stick_radius_mm * np.cos(angle))

    carried = quad(ring, 0.0, 0.5 * pi * (1.0 - 1e-12))[0]
    assert carried == pytest.approx(SHAPE.load_N(MODULUS), rel=1e-6)


def test_nothing_is_worn_in_the_stuck_centre_or_beyond_the_annulus() -> None:
    inside, outside = np.linspace(0.0, SHAPE.stick_radius_mm, 7), SHAPE.edge_radius_mm * np.array([1.0, 1.1, 3.0])
    assert SHAPE.depth(inside) == pytest.approx(np.zeros(7), abs=1e-15)
    assert SHAPE.depth(outside) == pytest.approx(np.zeros(3), abs=1e-15)


def test_steel_wires_wear_as_an_independent_evaluation_of_the_formula_says() -> None:
    assert 1e3 * SHAPE.deepest_mm[0] == pytest.approx(0.154, abs=1e-3)
    assert 1e3 * SHAPE.edge_radius_mm == pytest.approx(16.6, abs=0.1)
    assert 1e9 * SHAPE.volume_mm3 == pytest.approx(61.0, abs=0.7)
    least, most = WIRES.under_load(2.0)
    assert 1e3 * most.stick_radius_mm == pytest.approx(9.37, abs=0.02)
    assert 1e9 * most.volume_mm3 == pytest.approx(110.0, abs=1.5)
    assert 1e3 * most.deepest_mm[0] == pytest.approx(0.217, abs=2e-3)
    assert least.volume_mm3 < 0.6 * most.volume_mm3


@given(st.floats(0.1, 0.8), st.floats(0.0, 3e-5), st.floats(0.0, 1e-4))
def test_the_stuck_centre_is_about_to_slip_behind_any_bulk(share: float, normal: float, tangential: float) -> None:
    approach = 0.909e-3
    drive = share * WIRES.friction * MODULUS / SHEAR * approach
    contact = WearingContact(0.225, MODULUS, SHEAR, WIRES.friction, drive, normal, tangential)
    shape = contact.under_approach(approach)
    c, d = shape.stick_radius_mm, shape.approach_mm
    force = 2.0 * contact.friction * MODULUS * c * (d - c**2 / 0.225)
    assert d == pytest.approx(approach - normal * shape.load_N(MODULUS), rel=1e-9)
    assert SHEAR * (drive - tangential * force) == pytest.approx(contact.friction * MODULUS * (d - c**2 / 0.225))


def test_under_a_constant_load_both_shapes_carry_it_and_the_stick_zone_lies_between_them() -> None:
    least, most = WIRES.under_load(2.0)
    for shape in (least, most):
        assert shape.load_N(MODULUS) == pytest.approx(2.0, rel=1e-9)
    assert least.stick_radius_mm > most.stick_radius_mm
    assert least.volume_mm3 < most.volume_mm3


def test_a_drive_that_slides_the_whole_contact_has_no_limiting_shape() -> None:
    sliding = WearingContact(0.225, MODULUS, SHEAR, friction=0.62, drive_mm=2e-3)
    with pytest.raises(ValueError, match="nothing sticks"):
        sliding.under_load(2.0)


def test_a_stick_radius_beyond_the_contact_is_refused() -> None:
    with pytest.raises(ValueError, match="within the contact"):
        LimitingShape(0.225, 0.909e-3, 0.0145)
