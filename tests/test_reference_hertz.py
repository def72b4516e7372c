"""Hertz closed forms against integrals, limits, published tables and the steel-wire test's numbers."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wirewear.reference import (
    Elastic,
    contact_modulus,
    hertz_crossed_cylinders,
    hertz_elliptic,
    hertz_line,
    hertz_point,
    relative_curvatures,
    semi_axis_ratio,
    tangential_contact_modulus,
)
from wirewear.reference.hertz import PointContact

STEEL = Elastic(210000.0, 0.3)

# cos θ = (B − A)/(A + B); a = m·[3P/(4E*(A + B))]^⅓, b = n·[…]^⅓: Whittemore & Petrenko, NBS (1921)
TABLE = [(30, 2.731, 0.493), (45, 1.926, 0.604), (60, 1.486, 0.717), (75, 1.202, 0.846), (85, 1.061, 0.944), (90, 1, 1)]


def steel_wires() -> PointContact:
    return hertz_crossed_cylinders(2.0, 0.225, 0.225, 90.0, first=STEEL, second=STEEL)


def surface_displacement(contact: PointContact, modulus_MPa: float, x: float, y: float) -> float:
    """Boussinesq integral of the pressure over E*, in polar coordinates around (x, y)."""
    angles = (np.arange(720) + 0.5) * math.pi / 720
    a, b = contact.major_semi_axis_mm, contact.minor_semi_axis_mm
    # along each chord through the point the pressure is a half ellipse, whose integral is π/4 · length · its maximum
    cx, cy = np.cos(angles) / a, np.sin(angles) / b
    along, across = cx**2 + cy**2, cx * x / a + cy * y / b
    squared = across**2 / along + 1.0 - (x / a) ** 2 - (y / b) ** 2
    integrals = contact.peak_pressure_MPa * squared / np.sqrt(along) * math.pi / 2.0
    return float(integrals.sum() * math.pi / 720 / (math.pi * modulus_MPa))


def test_steel_wires_have_the_articles_contact() -> None:
    contact = steel_wires()
    assert contact.peak_pressure_MPa == pytest.approx(4669.0, rel=1e-4)
    assert contact.contact_radius_mm == pytest.approx(0.0143, rel=1e-3)
    assert contact.approach_mm == pytest.approx(0.909e-3, rel=1e-3)
    assert contact.mean_pressure_MPa == pytest.approx(3112.6, rel=1e-4)


def test_equal_wires_at_right_angles_touch_like_a_sphere_on_a_half_space() -> None:
    sphere = hertz_point(2.0, 0.225, contact_modulus(STEEL, STEEL))
    crossed = steel_wires()
    assert crossed.major_semi_axis_mm == pytest.approx(sphere.major_semi_axis_mm, rel=1e-12)
    assert crossed.minor_semi_axis_mm == pytest.approx(sphere.minor_semi_axis_mm, rel=1e-12)
    assert crossed.approach_mm == pytest.approx(sphere.approach_mm, rel=1e-12)


@pytest.mark.parametrize(("theta_deg", "m", "n"), TABLE)
def test_elliptic_contact_agrees_with_the_published_table(theta_deg: float, m: float, n: float) -> None:
    cosine = math.cos(math.radians(theta_deg))
    small, large = 1.0 - cosine, 1.0 + cosine
    contact = hertz_elliptic(1.0, small, large, 100.0)
    scale = (3.0 / (4.0 * 100.0 * (small + large))) ** (1.0 / 3.0)
    assert contact.major_semi_axis_mm == pytest.approx(m * scale, abs=1.2e-3 * scale)
    assert contact.minor_semi_axis_mm == pytest.approx(n * scale, abs=1.2e-3 * scale)


@given(
    st.floats(0.05, 2.0),
    st.floats(0.05, 2.0),
    st.floats(15.0, 165.0),
    st.floats(-0.6, 0.6),
    st.floats(-0.6, 0.6),
)
def test_elliptic_pressure_bends_the_surfaces_onto_each_other(
    first_mm: float, second_mm: float, angle_deg: float, x: float, y: float
) -> None:
    small, large, _ = relative_curvatures(first_mm, second_mm, angle_deg)
    modulus = contact_modulus(STEEL, STEEL)
    contact = hertz_elliptic(2.0, small, large, modulus)
    x_mm, y_mm = x * contact.major_semi_axis_mm, y * contact.minor_semi_axis_mm
    closed_gap = contact.approach_mm - small * x_mm**2 - large * y_mm**2
    assert surface_displacement(contact, modulus, x_mm, y_mm) == pytest.approx(closed_gap, rel=1e-6)


@given(st.floats(0.05, 2.0), st.floats(0.05, 2.0), st.floats(15.0, 165.0))
def test_pressure_integrates_to_the_load(first_mm: float, second_mm: float, angle_deg: float) -> None:
    contact = hertz_crossed_cylinders(3.0, first_mm, second_mm, angle_deg, first=STEEL, second=Elastic(70000.0, 0.33))
    radius = (np.arange(4000) + 0.5) / 4000
    rings = contact.pressure(radius * contact.major_semi_axis_mm) * 2.0 * math.pi * radius / 4000
    area = contact.major_semi_axis_mm * contact.minor_semi_axis_mm
    assert rings.sum() * area == pytest.approx(3.0, rel=1e-5)


@given(st.floats(0.05, 2.0), st.floats(0.05, 2.0), st.floats(1.0, 179.0))
def test_gap_curvatures_are_the_principal_ones_of_the_two_cylinders(
    first_mm: float, second_mm: float, angle_deg: float
) -> None:
    small, large, major = relative_curvatures(first_mm, second_mm, angle_deg)
    omega = math.radians(angle_deg)
    for direction, expected in ((major, small), (major + math.pi / 2, large)):
        gap = math.sin(direction) ** 2 / (2 * first_mm) + math.sin(direction - omega) ** 2 / (2 * second_mm)
        assert gap == pytest.approx(expected, rel=1e-6)


@given(st.floats(1.0, 1e10))
def test_a_more_elongated_gap_makes_a_more_elongated_ellipse(ratio: float) -> None:
    assert 0.0 < semi_axis_ratio(2.0 * ratio) < semi_axis_ratio(ratio) <= 1.0


def test_exchanging_the_wires_mirrors_the_contact() -> None:
    other = Elastic(116000.0, 0.3)
    one = hertz_crossed_cylinders(2.0, 0.2, 0.5, 60.0, first=STEEL, second=other)
    two = hertz_crossed_cylinders(2.0, 0.5, 0.2, 60.0, first=other, second=STEEL)
    assert one.major_semi_axis_mm == pytest.approx(two.major_semi_axis_mm, rel=1e-12)
    assert one.major_angle_rad == pytest.approx(math.radians(60.0) - two.major_angle_rad, rel=1e-12)


def test_line_contact_has_the_known_half_width_and_carries_its_load() -> None:
    titanium_like = Elastic(200000.0, 0.3)
    contact = hertz_line(120.0, 6.0, contact_modulus(titanium_like, titanium_like))
    assert contact.half_width_mm == pytest.approx(0.09134, abs=5e-6)
    assert contact.peak_pressure_MPa == pytest.approx(836.4, abs=0.05)
    x = np.linspace(-1.0, 1.0, 200001) * contact.half_width_mm
    assert np.trapezoid(contact.pressure(x), x) == pytest.approx(120.0, rel=1e-6)
    assert contact.mean_pressure_MPa * 2.0 * contact.half_width_mm == pytest.approx(120.0)


@pytest.mark.parametrize("share", [0.2, 0.5, 1.0, 2.0, 2.6])
def test_means_about_the_middle_are_the_load_there_over_the_length(share: float) -> None:
    """Against sums over the pressure itself; share: of the radius, or of half the width."""
    point, line = steel_wires(), hertz_line(120.0, 6.0, 1.1e5)
    r = (np.arange(20_000) + 0.5) / 20_000 * 0.5 * share * point.contact_radius_mm
    on_disc = float((point.pressure(r) * r).sum() / r.sum())
    assert point.mean_over_disc_MPa(share * point.contact_radius_mm) == pytest.approx(on_disc, rel=1e-4)
    x = (np.arange(20_000) + 0.5) / 20_000 * 0.5 * share * line.half_width_mm
    assert line.mean_over_segment_MPa(share * line.half_width_mm) == pytest.approx(line.pressure(x).mean(), rel=1e-4)


def test_means_over_a_disc_of_an_elliptic_contact_are_refused() -> None:
    with pytest.raises(ValueError, match="of a circular contact"):
        hertz_crossed_cylinders(2.0, 0.2, 0.4, 60.0, first=STEEL, second=STEEL).mean_over_disc_MPa(0.01)


def test_combined_moduli_of_like_bodies_follow_from_one_body() -> None:
    assert contact_modulus(STEEL, STEEL) == pytest.approx(210000.0 / (2 * 0.91))
    assert tangential_contact_modulus(STEEL, STEEL) == pytest.approx(2.0 * STEEL.shear_modulus_MPa / 1.7)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Elastic(-1.0, 0.3), "youngs_modulus_MPa must be positive"),
        (lambda: Elastic(1.0, 0.6), "poissons_ratio must lie between"),
        (lambda: hertz_point(0.0, 1.0, 1.0), "normal_load_N must be positive"),
        (lambda: relative_curvatures(1.0, 1.0, 180.0), "crossing_angle_deg must lie between"),
        (lambda: semi_axis_ratio(0.5), "curvature_ratio must be at least 1"),
    ],
)
def test_values_out_of_range_are_named(call: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call()  # type: ignore[operator]
