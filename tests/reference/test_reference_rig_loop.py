"""The loop behind a rig spring, and gross-slip wear, against numbers and integrals."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.arrays import Array
from solvers.elasticity.linear_elasticity import von_mises
from wirewear import reference
from wirewear.reference.wear import LineScar

A, P0, Q0, NU = 1.3, 7.0, 3.0, 0.3
STEEL_WIRES = reference.partial_slip_point(2.0, 0.62, 0.0143013, 2.0 * 210000.0 / 2.6 / 1.7)
STIFFNESSES = st.one_of(st.just(math.inf), st.floats(20.0, 1e5))


def sphere(x: float | Array, y: float | Array, z: float | Array) -> Array:
    return reference.sliding_stress(
        x, y, z, contact_radius_mm=A, peak_pressure_MPa=P0, peak_shear_MPa=Q0, poissons_ratio=NU
    )


def line(x: float | Array, _y: float | Array, z: float | Array) -> Array:
    return reference.line_stress(x, z, half_width_mm=A, peak_pressure_MPa=P0, peak_shear_MPa=Q0, poissons_ratio=NU)


def tensor(stress: Array) -> Array:
    xx, yy, zz, xy, yz, xz = stress
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


@pytest.mark.parametrize("stress", [sphere, line])
@pytest.mark.parametrize("at", [(0.3, 0.4, 0.2), (-1.25, 0.1, 0.3), (2.0, 1.0, 1.0)])
def test_stresses_balance(stress: Callable[[float, float, float], Array], at: tuple[float, float, float]) -> None:
    step = 1e-4
    divergence = np.zeros(3)
    for axis in range(3):
        ahead, behind = np.array(at), np.array(at)
        ahead[axis] += step
        behind[axis] -= step
        divergence += (tensor(stress(*ahead)) - tensor(stress(*behind)))[:, axis] / (2.0 * step)
    assert np.abs(divergence).max() < 1e-5 * P0 / A


@pytest.mark.parametrize("stress", [sphere, line])
def test_the_surface_carries_tractions_and_none_beside_it(stress: Callable[[Array, float, float], Array]) -> None:
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
    found = reference.hertz_stress(0.0, 0.0, z, contact_radius_mm=A, peak_pressure_MPa=P0, poissons_ratio=NU)
    down = -P0 / (1.0 + (z / A) ** 2)
    across = -P0 * ((1.0 + NU) * (1.0 - z / A * np.arctan2(A, z)) - 0.5 / (1.0 + (z / A) ** 2))
    np.testing.assert_allclose(found[:, 2], down, rtol=1e-9)
    np.testing.assert_allclose(found[:, 0], across, rtol=1e-8)
    np.testing.assert_allclose(found[:, 1], across, rtol=1e-8)


def test_the_largest_tension_is_at_the_edge_and_grows_with_friction() -> None:
    """(1 − 2ν) p0 / 3 without friction; Hamilton 1983 adds π (4 + ν) q0 / 8 behind the sliding sphere."""
    still = reference.hertz_stress(-A, 0.0, 0.0, contact_radius_mm=A, peak_pressure_MPa=P0, poissons_ratio=NU)
    assert still[0] == pytest.approx((1.0 - 2.0 * NU) * P0 / 3.0, rel=1e-6)
    assert still[1] == pytest.approx(-still[0], rel=1e-6)
    moving = sphere(np.array([-A, A]), 0.0, 0.0)[:, 0]
    assert moving - still[0] == pytest.approx(np.array([1.0, -1.0]) * np.pi * (4.0 + NU) / 8.0 * Q0, rel=1e-6)


@pytest.mark.seconds
def test_the_largest_von_mises_stress_lies_where_textbooks_say() -> None:
    """For ν = 0.3: 0.620 p0 at 0.48 a under a sphere, 0.558 p0 at 0.70 a under a line (Johnson, section 4.2)."""
    z = np.linspace(0.0, 2.0, 4001) * A
    round_one = von_mises(
        reference.hertz_stress(0.0, 0.0, z, contact_radius_mm=A, peak_pressure_MPa=1.0, poissons_ratio=NU)
    )
    long_one = von_mises(reference.line_stress(0.0, z, half_width_mm=A, peak_pressure_MPa=1.0, poissons_ratio=NU))
    assert round_one.max() == pytest.approx(0.620, abs=1e-3)
    assert z[round_one.argmax()] / A == pytest.approx(0.481, abs=5e-3)
    assert long_one.max() == pytest.approx(0.558, abs=1e-3)
    assert z[long_one.argmax()] / A == pytest.approx(0.704, abs=5e-3)


def test_partial_slip_shears_the_annulus_fully_and_stretches_no_line_centre() -> None:
    c, friction = 0.6 * A, 0.5
    round_one = reference.partial_slip_stress(
        np.array([0.0, 0.8 * A]), 0.0, 0.0, contact_radius_mm=A, stick_radius_mm=c, peak_pressure_MPa=P0,
        friction=friction, poissons_ratio=NU,
    )  # fmt: skip
    assert round_one[0, 5] == pytest.approx(-friction * P0 * (1.0 - c / A), rel=1e-6)
    assert round_one[1, 5] == pytest.approx(friction * round_one[1, 2], rel=1e-6)
    x = np.array([0.3 * A, 0.8 * A])
    long_one = reference.line_partial_slip_stress(
        x, 0.0, half_width_mm=A, stick_half_width_mm=c, peak_pressure_MPa=P0, friction=friction, poissons_ratio=NU
    )
    pressed = reference.line_stress(x, 0.0, half_width_mm=A, peak_pressure_MPa=P0, poissons_ratio=NU)
    assert long_one[0, 0] == pytest.approx(pressed[0, 0], rel=1e-9)
    at_edge = -2.0 * friction * P0 * np.sqrt(0.8**2 - 0.6**2)
    assert long_one[1, 0] - pressed[1, 0] == pytest.approx(at_edge, rel=1e-6)


def test_steel_wires_behind_the_articles_rig_dissipate_and_slip_as_computed_by_hand() -> None:
    assert reference.dissipated_energy(STEEL_WIRES, 0.06, 167.0) == pytest.approx(0.2580, abs=1e-4)
    assert reference.slip_amplitude(STEEL_WIRES, 0.06, 167.0) == pytest.approx(0.05207, abs=1e-5)
    assert reference.dissipated_energy(STEEL_WIRES, 0.06) == pytest.approx(0.2949, abs=1e-4)
    assert reference.slip_amplitude(STEEL_WIRES, 0.06) == pytest.approx(0.05949, abs=1e-5)


@pytest.mark.seconds
@given(STIFFNESSES, st.floats(0.05, 20.0))
def test_energy_and_slip_are_the_loops_area_and_half_width(rig: float, excess: float) -> None:
    amplitude = excess * reference.sliding_threshold(STEEL_WIRES, rig)
    path = amplitude * -np.cos(np.linspace(0.0, math.pi, 4001))
    forward = reference.branch_force(STEEL_WIRES, path, amplitude, rig, forward=True)
    backward = reference.branch_force(STEEL_WIRES, path, amplitude, rig, forward=False)
    area = float(np.trapezoid(forward - backward, path))
    assert reference.dissipated_energy(STEEL_WIRES, amplitude, rig) == pytest.approx(area, rel=2e-4)
    half_width = 0.5 * (np.interp(0.0, backward, path) - np.interp(0.0, forward, path))
    assert reference.slip_amplitude(STEEL_WIRES, amplitude, rig) == pytest.approx(half_width, rel=1e-3)


@given(STIFFNESSES, st.floats(0.1, 10.0))
def test_a_branch_leaves_its_reversal_with_the_series_stiffness(rig: float, excess: float) -> None:
    amplitude = excess * reference.sliding_threshold(STEEL_WIRES, rig)
    step = 1e-5 * reference.sliding_threshold(STEEL_WIRES, rig)
    ends = reference.branch_force(STEEL_WIRES, [amplitude, amplitude - step], amplitude, rig, forward=False)
    slope = (ends[0] - ends[1]) / step
    assert slope == pytest.approx(reference.unloading_stiffness(STEEL_WIRES, rig), rel=1e-4)


@pytest.mark.seconds
@given(STIFFNESSES, st.floats(0.1, 10.0), st.integers(8, 200))
def test_a_closed_loop_lies_on_its_branches_and_is_point_symmetric(rig: float, excess: float, quarters: int) -> None:
    amplitude = excess * reference.sliding_threshold(STEEL_WIRES, rig)
    loop = reference.closed_loop(STEEL_WIRES, amplitude, rig, 4 * quarters)
    half = 2 * quarters
    assert loop.displacement_mm[0] == 0.0
    assert loop.displacement_mm[1] > 0.0
    np.testing.assert_allclose(loop.tangential_force_N[half:], -loop.tangential_force_N[:half], atol=1e-9)
    assert np.abs(loop.tangential_force_N).max() <= STEEL_WIRES.limit_N * (1.0 + 1e-12)
    first_half = reference.branch_force(STEEL_WIRES, loop.displacement_mm[:quarters], amplitude, rig, forward=True)
    np.testing.assert_allclose(loop.tangential_force_N[:quarters], first_half)


@given(st.floats(1e-7, 1e-2), st.floats(0.05, 10.0))
def test_the_worn_volume_is_the_overlap_of_the_two_wires(volume_mm3: float, radius_mm: float) -> None:
    scar = reference.crossed_wire_scar(volume_mm3, radius_mm)
    r = np.linspace(0.0, scar.radius_mm, 4001)
    overlap = np.trapezoid((scar.depth_mm - r**2 / (2 * radius_mm)) * 2 * math.pi * r, r)
    assert overlap == pytest.approx(volume_mm3, rel=1e-5)
    assert reference.worn_pressure(2.0, scar) * math.pi * scar.radius_mm**2 == pytest.approx(2.0)


def test_the_worn_area_of_a_cylinder_is_its_overlap_with_the_flat() -> None:
    scar: LineScar = reference.line_contact_scar(1e-3, 6.0)
    x = np.linspace(-scar.half_width_mm, scar.half_width_mm, 4001)
    assert np.trapezoid(scar.depth_mm - x**2 / 12.0, x) == pytest.approx(1e-3, rel=1e-5)


def amplification(cycles: float, wave_number: float, h_mm: float) -> float:
    """Growth factor of a pressure ripple on a line of nodes, from a discrete half-plane influence in Fourier space."""
    depth_per_cycle_and_pressure = 3e-8 * 0.62 * 0.208
    return 1.0 - cycles * depth_per_cycle_and_pressure * 115385.0 * wave_number / (2.0 * h_mm)


@pytest.mark.parametrize(("plane", "wave_number"), [(True, math.pi), (False, math.pi * math.sqrt(2.0))])
def test_the_explicit_limit_is_where_the_shortest_ripple_flips_without_decay(plane: bool, wave_number: float) -> None:
    limit = reference.explicit_stability_limit(0.005, 3e-5, 0.62, 115385.0, 0.208, plane=plane)
    assert amplification(limit, wave_number, 0.005) == pytest.approx(-1.0)
    assert 10.0 < limit < 14.3
