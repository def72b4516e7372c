"""Cattaneo–Mindlin closed forms against integrals of their own tractions and loops."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wirewear.reference import (
    PartialSlipPoint,
    displacement_after_reversal,
    energy_per_cycle,
    hertz_line,
    line_loading_traction,
    line_stick_ratio,
    line_stick_ratio_after_reversal,
    line_traction_after_reversal,
    loading_displacement,
    loading_force,
    loading_traction,
    partial_slip_point,
    stick_radius,
    stick_radius_after_reversal,
    traction_after_reversal,
)

CONTACT = PartialSlipPoint(2.0, 0.62, 0.0143, 2700.0)
LINE = hertz_line(120.0, 6.0, 200000.0 / (2 * 0.91))
RATIOS = st.floats(0.02, 1.0)


def disc_integral(values: np.ndarray, radius: np.ndarray) -> float:
    return float(np.trapezoid(values * 2.0 * math.pi * radius, radius))


def test_mindlin_stiffness_of_the_steel_wires_is_sixteen_times_the_rigs() -> None:
    steel = partial_slip_point(2.0, 0.62, 0.0143013, 2.0 * 210000.0 / 2.6 / 1.7)
    assert steel.stiffness_N_per_mm / 167.0 == pytest.approx(16.3, abs=0.1)


@given(RATIOS)
def test_traction_integrates_to_the_tangential_force(ratio: float) -> None:
    radius = np.linspace(0.0, CONTACT.contact_radius_mm, 20001)
    force = ratio * CONTACT.limit_N
    assert disc_integral(loading_traction(CONTACT, radius, force), radius) == pytest.approx(force, rel=1e-4, abs=1e-5)


@given(RATIOS, st.floats(-1.0, 1.0))
def test_traction_after_reversal_integrates_to_the_force_and_keeps_coulombs_law(ratio: float, part: float) -> None:
    radius = np.linspace(0.0, CONTACT.contact_radius_mm, 20001)
    peak = ratio * CONTACT.limit_N
    traction = traction_after_reversal(CONTACT, radius, part * peak, peak)
    assert disc_integral(traction, radius) == pytest.approx(part * peak, abs=2e-4)
    limit = loading_traction(CONTACT, radius, CONTACT.limit_N)
    assert np.all(np.abs(traction) <= limit * (1.0 + 1e-9) + 1e-9)


@given(RATIOS, st.floats(-0.9, 0.9))
def test_only_the_annulus_outside_the_new_stick_circle_slips_back(ratio: float, part: float) -> None:
    peak = ratio * CONTACT.limit_N
    inner = stick_radius_after_reversal(CONTACT, part * peak, peak)
    radius = np.linspace(inner, CONTACT.contact_radius_mm, 50)
    limit = loading_traction(CONTACT, radius, CONTACT.limit_N)
    np.testing.assert_allclose(traction_after_reversal(CONTACT, radius, part * peak, peak), -limit, atol=1e-6)
    assert inner > float(stick_radius(CONTACT, peak))


@given(st.floats(-1.0, 1.0))
def test_force_and_displacement_of_first_loading_are_inverse(ratio: float) -> None:
    force = ratio * CONTACT.limit_N
    assert float(loading_force(CONTACT, loading_displacement(CONTACT, force))) == pytest.approx(force, abs=1e-9)


def test_first_loading_starts_at_mindlins_stiffness_and_slides_at_one_and_a_half() -> None:
    small = 1e-6 * CONTACT.limit_N
    assert small / float(loading_displacement(CONTACT, small)) == pytest.approx(CONTACT.stiffness_N_per_mm, rel=1e-5)
    slide = float(loading_displacement(CONTACT, CONTACT.limit_N))
    assert slide == pytest.approx(1.5 * CONTACT.limit_N / CONTACT.stiffness_N_per_mm)
    assert float(loading_force(CONTACT, 3.0 * slide)) == CONTACT.limit_N


@given(RATIOS)
def test_unloading_and_reloading_close_the_loop(ratio: float) -> None:
    peak = ratio * CONTACT.limit_N
    top = float(loading_displacement(CONTACT, peak))
    assert float(displacement_after_reversal(CONTACT, -peak, peak)) == pytest.approx(-top, rel=1e-9)
    assert float(displacement_after_reversal(CONTACT, peak, -peak)) == pytest.approx(top, rel=1e-9)


@given(st.floats(1e-4, 1.0))
def test_energy_of_a_cycle_is_the_area_of_its_loop(ratio: float) -> None:
    peak = ratio * CONTACT.limit_N
    # graded towards the ends of the branch, where its curvature is singular
    force = peak * np.sin(np.linspace(-math.pi / 2, math.pi / 2, 4001))
    opening = displacement_after_reversal(CONTACT, force, peak) - displacement_after_reversal(CONTACT, force, -peak)
    assert energy_per_cycle(CONTACT, peak) == pytest.approx(float(np.trapezoid(opening, force)), rel=1e-5)


def test_a_force_beyond_sliding_is_refused() -> None:
    with pytest.raises(ValueError, match="must not exceed"):
        loading_displacement(CONTACT, 1.1 * CONTACT.limit_N)
    with pytest.raises(ValueError, match="must not exceed"):
        line_stick_ratio(-1.01, 1.0)


def test_line_contact_sticks_as_in_the_known_case() -> None:
    limit = 0.6 * 120.0
    assert line_stick_ratio(0.5 * limit, limit) == pytest.approx(0.7071, abs=5e-5)
    assert line_stick_ratio_after_reversal(0.0, 0.5 * limit, limit) == pytest.approx(0.8660, abs=5e-5)


@given(RATIOS, st.floats(-1.0, 1.0))
def test_line_tractions_integrate_to_the_force_and_keep_coulombs_law(ratio: float, part: float) -> None:
    limit = 0.6 * 120.0
    x = np.sin(np.linspace(-math.pi / 2, math.pi / 2, 20001)) * LINE.half_width_mm
    first = line_loading_traction(LINE, 0.6, x, ratio * limit)
    after = line_traction_after_reversal(LINE, 0.6, x, part * ratio * limit, ratio * limit)
    assert np.trapezoid(first, x) == pytest.approx(ratio * limit, abs=1e-3)
    assert np.trapezoid(after, x) == pytest.approx(part * ratio * limit, abs=1e-3)
    assert np.all(np.abs(after) <= 0.6 * LINE.pressure(x) * (1 + 1e-9) + 1e-9)
