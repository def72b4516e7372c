"""Closed forms of stresses under contacts: limits known by themselves, equilibrium, tractions on the surface."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from solvers.strain import von_mises
from wirewear.reference import (
    hertz_stress,
    line_partial_slip_stress,
    line_stress,
    partial_slip_stress,
    sliding_stress,
)

Array = NDArray[np.float64]

A, P0, Q0, NU = 1.3, 7.0, 3.0, 0.3


def sphere(x: float | Array, y: float | Array, z: float | Array) -> Array:
    return sliding_stress(x, y, z, contact_radius_mm=A, peak_pressure_MPa=P0, peak_shear_MPa=Q0, poissons_ratio=NU)


def line(x: float | Array, _y: float | Array, z: float | Array) -> Array:
    return line_stress(x, z, half_width_mm=A, peak_pressure_MPa=P0, peak_shear_MPa=Q0, poissons_ratio=NU)


def tensor(stress: Array) -> Array:
    xx, yy, zz, xy, yz, xz = stress
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


@pytest.mark.parametrize("stress", [sphere, line])
@pytest.mark.parametrize("at", [(0.3, 0.4, 0.2), (-1.25, 0.1, 0.3), (2.0, 1.0, 1.0)])
def test_stresses_are_in_equilibrium(
    stress: Callable[[float, float, float], Array], at: tuple[float, float, float]
) -> None:
    step = 1e-4
    divergence = np.zeros(3)
    for axis in range(3):
        ahead, behind = np.array(at), np.array(at)
        ahead[axis] += step
        behind[axis] -= step
        divergence += (tensor(stress(*ahead)) - tensor(stress(*behind)))[:, axis] / (2.0 * step)
    assert np.abs(divergence).max() < 1e-5 * P0 / A


@pytest.mark.parametrize("stress", [sphere, line])
def test_the_surface_carries_the_tractions_and_nothing_beside_the_contact(
    stress: Callable[[Array, float, float], Array],
) -> None:
    x = np.linspace(-2.0 * A, 2.0 * A, 41)
    found = stress(x, 0.0, 0.0)
    share = np.sqrt(np.maximum(1.0 - (x / A) ** 2, 0.0))
    np.testing.assert_allclose(found[:, 2], -P0 * share, atol=2e-6)
    # The shear acts on the body along +x on the face whose outward normal is -z.
    np.testing.assert_allclose(found[:, 5], -Q0 * share, atol=2e-6)
    np.testing.assert_allclose(found[:, 4], 0.0, atol=1e-12)


def test_on_the_axis_of_a_sphere_stresses_are_those_of_the_textbook() -> None:
    """Johnson, Contact Mechanics, 1985, eq. 3.45."""
    z = np.array([0.0, 0.1, 0.5, 1.0, 4.0]) * A
    found = hertz_stress(0.0, 0.0, z, contact_radius_mm=A, peak_pressure_MPa=P0, poissons_ratio=NU)
    down = -P0 / (1.0 + (z / A) ** 2)
    across = -P0 * ((1.0 + NU) * (1.0 - z / A * np.arctan2(A, z)) - 0.5 / (1.0 + (z / A) ** 2))
    np.testing.assert_allclose(found[:, 2], down, rtol=1e-9)
    np.testing.assert_allclose(found[:, 0], across, rtol=1e-8)
    np.testing.assert_allclose(found[:, 1], across, rtol=1e-8)


def test_the_largest_tension_is_at_the_edge_and_grows_with_friction() -> None:
    """(1 − 2ν) p0 / 3 without friction; Hamilton 1983 adds π (4 + ν) q0 / 8 behind the sliding sphere."""
    still = hertz_stress(-A, 0.0, 0.0, contact_radius_mm=A, peak_pressure_MPa=P0, poissons_ratio=NU)
    assert still[0] == pytest.approx((1.0 - 2.0 * NU) * P0 / 3.0, rel=1e-6)
    assert still[1] == pytest.approx(-still[0], rel=1e-6)
    moving = sphere(np.array([-A, A]), 0.0, 0.0)[:, 0]
    assert moving - still[0] == pytest.approx(np.array([1.0, -1.0]) * np.pi * (4.0 + NU) / 8.0 * Q0, rel=1e-6)


def test_far_away_a_sphere_is_a_point_force() -> None:
    """Boussinesq: σ_zz = −3 P z³ / 2π ρ⁵; Cerruti: the same with x z² Q."""
    x, y, z = 30.0, 20.0, 40.0
    rho = np.sqrt(x**2 + y**2 + z**2)
    load, shear = (2.0 / 3.0 * np.pi * A**2 * peak for peak in (P0, Q0))
    expected = -1.5 * z**2 * (load * z + shear * x) / (np.pi * rho**5)
    assert sphere(x, y, z)[2] == pytest.approx(expected, rel=2e-3)


def test_the_largest_von_mises_stress_lies_where_textbooks_say() -> None:
    """For ν = 0.3: 0.620 p0 at 0.48 a under a sphere, 0.558 p0 at 0.70 a under a line (Johnson, section 4.2)."""
    z = np.linspace(0.0, 2.0, 4001) * A
    round_one = von_mises(hertz_stress(0.0, 0.0, z, contact_radius_mm=A, peak_pressure_MPa=1.0, poissons_ratio=NU))
    long_one = von_mises(line_stress(0.0, z, half_width_mm=A, peak_pressure_MPa=1.0, poissons_ratio=NU))
    assert round_one.max() == pytest.approx(0.620, abs=1e-3)
    assert z[round_one.argmax()] / A == pytest.approx(0.481, abs=5e-3)
    assert long_one.max() == pytest.approx(0.558, abs=1e-3)
    assert z[long_one.argmax()] / A == pytest.approx(0.704, abs=5e-3)


def test_in_partial_slip_the_shear_is_full_in_the_annulus_and_nothing_stretches_the_centre_of_a_line() -> None:
    c, friction = 0.6 * A, 0.5
    round_one = partial_slip_stress(
        np.array([0.0, 0.8 * A]),
        0.0,
        0.0,
        contact_radius_mm=A,
        stick_radius_mm=c,
        peak_pressure_MPa=P0,
        friction=friction,
        poissons_ratio=NU,
    )
    assert round_one[0, 5] == pytest.approx(-friction * P0 * (1.0 - c / A), rel=1e-6)
    assert round_one[1, 5] == pytest.approx(friction * round_one[1, 2], rel=1e-6)
    x = np.array([0.3 * A, 0.8 * A])
    long_one = line_partial_slip_stress(
        x,
        0.0,
        half_width_mm=A,
        stick_half_width_mm=c,
        peak_pressure_MPa=P0,
        friction=friction,
        poissons_ratio=NU,
    )
    pressed = line_stress(x, 0.0, half_width_mm=A, peak_pressure_MPa=P0, poissons_ratio=NU)
    assert long_one[0, 0] == pytest.approx(pressed[0, 0], rel=1e-9)
    at_edge = -2.0 * friction * P0 * np.sqrt(0.8**2 - 0.6**2)
    assert long_one[1, 0] - pressed[1, 0] == pytest.approx(at_edge, rel=1e-6)


def test_a_point_above_the_surface_is_refused() -> None:
    with pytest.raises(ValueError, match="above"):
        sphere(0.0, 0.0, -0.1)
    with pytest.raises(ValueError, match="above"):
        line(0.0, 0.0, -0.1)
