"""Hertz closed forms against integrals, limits, published tables and the steel-wire test's numbers."""

import math
from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import ellipk

from wirewear import reference
from wirewear.reference.hertz import PointContact

STEEL = reference.Elastic(210_000.0, 0.3)
MODULUS = reference.contact_modulus(STEEL, STEEL)
SHEAR = reference.tangential_contact_modulus(STEEL, STEEL)
#: Steel wires of 0.45 mm crossed at right angles, moved by ±0.39 µm where they touch.
WIRES = reference.WearingContact(0.225, MODULUS, SHEAR, friction=0.62, drive_mm=0.39e-3)
SHAPE = reference.LimitingShape(0.225, approach_mm=0.909e-3, stick_radius_mm=9.37e-3)
CONTACT = reference.PartialSlipPoint(2.0, 0.62, 0.0143, 2700.0)
LINE = reference.hertz_line(120.0, 6.0, 200000.0 / (2 * 0.91))
RATIOS = st.floats(0.02, 1.0)
# cos θ = (B − A)/(A + B); a = m·[3P/(4E*(A + B))]^⅓, b = n·[…]^⅓: Whittemore & Petrenko, NBS (1921)
TABLE = [(30, 2.731, 0.493), (45, 1.926, 0.604), (60, 1.486, 0.717), (75, 1.202, 0.846), (85, 1.061, 0.944), (90, 1, 1)]


def displacement(shape: reference.LimitingShape, radius_mm: float) -> float:
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


def test_the_stuck_centre_carries_the_load_and_steel_wires_wear_as_evaluated_independently() -> None:
    def ring(angle: float) -> float:
        s = SHAPE.stick_radius_mm * np.sin(angle)
        return float(2.0 * pi * s * SHAPE.pressure(s, MODULUS) * SHAPE.stick_radius_mm * np.cos(angle))

    carried = quad(ring, 0.0, 0.5 * pi * (1.0 - 1e-12))[0]
    assert carried == pytest.approx(SHAPE.load_N(MODULUS), rel=1e-6)
    assert 1e3 * SHAPE.deepest_mm[0] == pytest.approx(0.154, abs=1e-3)
    assert 1e3 * SHAPE.edge_radius_mm == pytest.approx(16.6, abs=0.1)
    assert 1e9 * SHAPE.volume_mm3 == pytest.approx(61.0, abs=0.7)


#: Volume in µm³ and outer edge in µm of a ball of 12.7 mm on a flat under 40 N, evaluated independently.
@pytest.mark.parametrize(
    ("share", "volume_um3", "edge_um"), [(0.3, 792.8, 125.891), (0.6, 8076.3, 140.359), (0.8, 33156.0, 161.533)]
)
def test_wear_under_a_held_force_ends_as_evaluated_independently(
    share: float, volume_um3: float, edge_um: float
) -> None:
    shape = reference.worn_under_load(6.35, MODULUS, 40.0, share)
    assert shape.load_N(MODULUS) == pytest.approx(40.0)
    assert 2.0 * SHEAR * shape.stick_radius_mm * shape.slip_mm(0.6, MODULUS, SHEAR) == pytest.approx(share * 24.0)
    assert 1e9 * shape.volume_mm3 == pytest.approx(volume_um3, rel=1e-4)
    assert 1e3 * shape.edge_radius_mm == pytest.approx(edge_um, rel=1e-5)


def test_an_annulus_that_slides_over_a_curved_face_wears_until_it_touches_at_neither_end() -> None:
    slip, curvature = 1e-5, 2.0
    lines = np.linspace(0.0, SHAPE.edge_radius_mm, 2001)
    x, y = lines[:, None], lines
    r = np.hypot(x, y)
    slid = slip * (1.0 - 2.0 / pi * np.arcsin(np.minimum(SHAPE.stick_radius_mm / np.maximum(r, 1e-12), 1.0)))
    more = 4.0 * float(np.where(r < SHAPE.edge_radius_mm, curvature * x * slid, 0.0).sum()) * lines[1] ** 2
    assert SHAPE.volume_after_slip_mm3(slip, curvature) - SHAPE.volume_mm3 == pytest.approx(more, rel=2e-3)


@given(st.floats(0.1, 0.8), st.floats(0.0, 3e-5), st.floats(0.0, 1e-4))
def test_the_stuck_centre_is_about_to_slip_behind_any_bulk(share: float, normal: float, tangential: float) -> None:
    approach = 0.909e-3
    drive = share * WIRES.friction * MODULUS / SHEAR * approach
    contact = reference.WearingContact(0.225, MODULUS, SHEAR, WIRES.friction, drive, normal, tangential)
    shape = contact.under_approach(approach)
    c, d = shape.stick_radius_mm, shape.approach_mm
    force = 2.0 * contact.friction * MODULUS * c * (d - c**2 / 0.225)
    assert d == pytest.approx(approach - normal * shape.load_N(MODULUS), rel=1e-9)
    assert SHEAR * (drive - tangential * force) == pytest.approx(contact.friction * MODULUS * (d - c**2 / 0.225))


@given(RATIOS, st.floats(-1.0, 1.0))
def test_traction_after_reversal_integrates_to_the_force_and_keeps_coulombs_law(ratio: float, part: float) -> None:
    radius = np.linspace(0.0, CONTACT.contact_radius_mm, 20001)
    peak = ratio * CONTACT.limit_N
    traction = reference.traction_after_reversal(CONTACT, radius, part * peak, peak)
    assert np.trapezoid(traction * 2.0 * math.pi * radius, radius) == pytest.approx(part * peak, abs=2e-4)
    limit = reference.loading_traction(CONTACT, radius, CONTACT.limit_N)
    assert np.all(np.abs(traction) <= limit * (1.0 + 1e-9) + 1e-9)


@given(RATIOS, st.floats(-0.9, 0.9))
def test_only_the_annulus_outside_the_new_stick_circle_slips_back(ratio: float, part: float) -> None:
    peak = ratio * CONTACT.limit_N
    inner = reference.stick_radius_after_reversal(CONTACT, part * peak, peak)
    radius = np.linspace(inner, CONTACT.contact_radius_mm, 50)
    limit = reference.loading_traction(CONTACT, radius, CONTACT.limit_N)
    # On the circle itself the root of a round-off is left of the traction that vanishes there.
    reversed_by = reference.traction_after_reversal(CONTACT, radius, part * peak, peak)
    np.testing.assert_allclose(reversed_by, -limit, rtol=1e-6, atol=1e-6)
    assert inner > float(reference.stick_radius(CONTACT, peak))


@given(st.floats(-1.0, 1.0))
def test_force_and_displacement_of_first_loading_are_inverse(ratio: float) -> None:
    force = ratio * CONTACT.limit_N
    assert float(reference.loading_force(CONTACT, reference.loading_displacement(CONTACT, force))) == pytest.approx(
        force, abs=1e-9
    )


def test_first_loading_starts_at_mindlins_stiffness_and_slides_at_one_and_a_half() -> None:
    small = 1e-6 * CONTACT.limit_N
    assert small / float(reference.loading_displacement(CONTACT, small)) == pytest.approx(
        CONTACT.stiffness_N_per_mm, rel=1e-5
    )
    slide = float(reference.loading_displacement(CONTACT, CONTACT.limit_N))
    assert slide == pytest.approx(1.5 * CONTACT.limit_N / CONTACT.stiffness_N_per_mm)
    assert float(reference.loading_force(CONTACT, 3.0 * slide)) == CONTACT.limit_N


@given(st.floats(1e-4, 1.0))
def test_energy_of_a_cycle_is_the_area_of_its_loop(ratio: float) -> None:
    peak = ratio * CONTACT.limit_N
    # graded towards the ends of the branch, where its curvature is singular
    force = peak * np.sin(np.linspace(-math.pi / 2, math.pi / 2, 4001))
    opening = reference.displacement_after_reversal(CONTACT, force, peak) - reference.displacement_after_reversal(
        CONTACT, force, -peak
    )
    assert reference.energy_per_cycle(CONTACT, peak) == pytest.approx(float(np.trapezoid(opening, force)), rel=1e-5)


def test_line_contact_sticks_as_in_the_known_case() -> None:
    limit = 0.6 * 120.0
    assert reference.line_stick_ratio(0.5 * limit, limit) == pytest.approx(0.7071, abs=5e-5)
    assert reference.line_stick_ratio_after_reversal(0.0, 0.5 * limit, limit) == pytest.approx(0.8660, abs=5e-5)


@given(RATIOS, st.floats(-1.0, 1.0))
def test_line_tractions_integrate_to_the_force_and_keep_coulombs_law(ratio: float, part: float) -> None:
    limit = 0.6 * 120.0
    x = np.sin(np.linspace(-math.pi / 2, math.pi / 2, 20001)) * LINE.half_width_mm
    first = reference.line_loading_traction(LINE, 0.6, x, ratio * limit)
    after = reference.line_traction_after_reversal(LINE, 0.6, x, part * ratio * limit, ratio * limit)
    assert np.trapezoid(first, x) == pytest.approx(ratio * limit, abs=1e-3)
    assert np.trapezoid(after, x) == pytest.approx(part * ratio * limit, abs=1e-3)
    assert np.all(np.abs(after) <= 0.6 * LINE.pressure(x) * (1 + 1e-9) + 1e-9)


def steel_wires() -> PointContact:
    return reference.hertz_crossed_cylinders(2.0, 0.225, 0.225, 90.0, first=STEEL, second=STEEL)


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


@pytest.mark.parametrize(("theta_deg", "m", "n"), TABLE)
def test_elliptic_contact_agrees_with_the_published_table(theta_deg: float, m: float, n: float) -> None:
    cosine = math.cos(math.radians(theta_deg))
    small, large = 1.0 - cosine, 1.0 + cosine
    contact = reference.hertz_elliptic(1.0, small, large, 100.0)
    scale = (3.0 / (4.0 * 100.0 * (small + large))) ** (1.0 / 3.0)
    assert contact.major_semi_axis_mm == pytest.approx(m * scale, abs=1.2e-3 * scale)
    assert contact.minor_semi_axis_mm == pytest.approx(n * scale, abs=1.2e-3 * scale)


@given(st.floats(0.05, 2.0), st.floats(0.05, 2.0), st.floats(15.0, 165.0), st.floats(-0.6, 0.6), st.floats(-0.6, 0.6))
def test_elliptic_pressure_bends_the_surfaces_onto_each_other(
    first_mm: float, second_mm: float, angle_deg: float, x: float, y: float
) -> None:
    small, large, _ = reference.relative_curvatures(first_mm, second_mm, angle_deg)
    modulus = reference.contact_modulus(STEEL, STEEL)
    contact = reference.hertz_elliptic(2.0, small, large, modulus)
    x_mm, y_mm = x * contact.major_semi_axis_mm, y * contact.minor_semi_axis_mm
    closed_gap = contact.approach_mm - small * x_mm**2 - large * y_mm**2
    assert surface_displacement(contact, modulus, x_mm, y_mm) == pytest.approx(closed_gap, rel=1e-6)


@given(st.floats(0.05, 2.0), st.floats(0.05, 2.0), st.floats(15.0, 165.0))
def test_pressure_integrates_to_the_load(first_mm: float, second_mm: float, angle_deg: float) -> None:
    contact = reference.hertz_crossed_cylinders(
        3.0, first_mm, second_mm, angle_deg, first=STEEL, second=reference.Elastic(70000.0, 0.33)
    )
    radius = (np.arange(4000) + 0.5) / 4000
    a, b = contact.major_semi_axis_mm, contact.minor_semi_axis_mm
    for direction in (0.0, 1.0, math.pi / 2.0):
        pressure = contact.pressure(radius * a * math.cos(direction), radius * b * math.sin(direction))
        assert (pressure * 2.0 * math.pi * radius / 4000).sum() * a * b == pytest.approx(3.0, rel=1e-5)


@given(st.floats(0.05, 2.0), st.floats(0.05, 2.0), st.floats(1.0, 179.0))
def test_gap_curvatures_are_the_principal_ones_of_both(first_mm: float, second_mm: float, angle_deg: float) -> None:
    small, large, major = reference.relative_curvatures(first_mm, second_mm, angle_deg)
    omega = math.radians(angle_deg)
    for direction, expected in ((major, small), (major + math.pi / 2, large)):
        gap = math.sin(direction) ** 2 / (2 * first_mm) + math.sin(direction - omega) ** 2 / (2 * second_mm)
        assert gap == pytest.approx(expected, rel=1e-6)


def test_line_contact_has_the_known_half_width_and_carries_its_load() -> None:
    titanium_like = reference.Elastic(200000.0, 0.3)
    contact = reference.hertz_line(120.0, 6.0, reference.contact_modulus(titanium_like, titanium_like))
    assert contact.half_width_mm == pytest.approx(0.09134, abs=5e-6)
    assert contact.peak_pressure_MPa == pytest.approx(836.4, abs=0.05)
    x = np.linspace(-1.0, 1.0, 200001) * contact.half_width_mm
    assert np.trapezoid(contact.pressure(x), x) == pytest.approx(120.0, rel=1e-6)
    assert contact.mean_pressure_MPa * 2.0 * contact.half_width_mm == pytest.approx(120.0)


@pytest.mark.parametrize("share", [0.2, 0.5, 1.0, 2.0, 2.6])
def test_means_about_the_middle_are_the_load_there_over_the_length(share: float) -> None:
    """Against sums over the pressure itself; share: of the radius, or of half the width."""
    point, line = steel_wires(), reference.hertz_line(120.0, 6.0, 1.1e5)
    r = (np.arange(20_000) + 0.5) / 20_000 * 0.5 * share * point.contact_radius_mm
    on_disc = float((point.pressure(r) * r).sum() / r.sum())
    assert point.mean_over_disc_MPa(share * point.contact_radius_mm) == pytest.approx(on_disc, rel=1e-4)
    x = (np.arange(20_000) + 0.5) / 20_000 * 0.5 * share * line.half_width_mm
    assert line.mean_over_segment_MPa(share * line.half_width_mm) == pytest.approx(line.pressure(x).mean(), rel=1e-4)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: reference.Elastic(-1.0, 0.3), "youngs_modulus_MPa must be positive"),
        (lambda: reference.Elastic(1.0, 0.6), "poissons_ratio must lie between"),
        (lambda: reference.hertz_point(0.0, 1.0, 1.0), "normal_load_N must be positive"),
        (lambda: reference.relative_curvatures(1.0, 1.0, 180.0), "crossing_angle_deg must lie between"),
        (lambda: reference.semi_axis_ratio(0.5), "curvature_ratio must be at least 1"),
    ],
)
def test_values_out_of_range_are_named(call: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call()  # type: ignore[operator]


PULLED = reference.hertz_line(150.0, 25.0, MODULUS)


@pytest.mark.parametrize("share", [0.15, 0.5, 0.95])
def test_the_energy_of_a_line_contacts_cycle_is_the_closed_forms(share: float) -> None:
    # The area of the loop of Johnson 1985, section 7.2, by integration.
    exact = 1.4 / (pi * STEEL.shear_modulus_MPa) * 90.0**2
    exact *= 2.0 * (1.0 - share) * np.log(1.0 - share) + 2.0 * share - share**2
    assert reference.line_energy_per_cycle(PULLED, 0.6, MODULUS, 90.0 * share) == pytest.approx(exact, rel=1e-6)


def test_a_bulk_stress_rubs_a_line_contact_as_a_plane_code_has_it_and_either_way_alike() -> None:
    both = [reference.line_energy_per_cycle(PULLED, 0.6, MODULUS, 27.0, bulk) for bulk in (60.0, -60.0)]
    # By an active set on 400 elements of a half-plane.
    assert both == pytest.approx([6.2828e-4, 6.2828e-4], rel=1e-3)
    with pytest.raises(ValueError, match="within the contact"):
        reference.line_energy_per_cycle(PULLED, 0.6, MODULUS, 27.0, 400.0)


@pytest.mark.parametrize(
    ("ratio", "along", "across"), [(1.0, 2.35294, 2.35294), (1.5, 1.90710, 1.97597), (6.0, 1.08307, 1.24264)]
)
def test_an_ellipse_that_sticks_is_as_stiff_as_boundary_elements_and_mindlin_have_it(
    ratio: float, along: float, across: float
) -> None:
    contact, unit = PointContact(1.0, 2.0, 2.0 / ratio, 1.0, 1.0), 2.0 * STEEL.shear_modulus_MPa
    found = [reference.elliptic_stiffness(contact, STEEL, angle) / unit for angle in (0.0, 0.5 * pi, 0.25 * pi)]
    assert found == pytest.approx([along, across, 0.5 * (along + across)], rel=1e-5)
