"""The loop behind a rig spring, and gross-slip wear, against numbers and integrals."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wirewear.reference import (
    PartialSlipPoint,
    branch_force,
    closed_loop,
    crossed_wire_scar,
    dissipated_energy,
    explicit_stability_limit,
    first_loading_force,
    line_contact_scar,
    loading_displacement,
    partial_slip_point,
    sliding_threshold,
    slip_amplitude,
    unloading_stiffness,
    worn_pressure,
    worn_volume,
)
from wirewear.reference.wear import LineScar

STEEL_WIRES = partial_slip_point(2.0, 0.62, 0.0143013, 2.0 * 210000.0 / 2.6 / 1.7)
STIFFNESSES = st.one_of(st.just(math.inf), st.floats(20.0, 1e5))


def test_steel_wires_behind_the_articles_rig_dissipate_and_slip_as_computed_by_hand() -> None:
    assert dissipated_energy(STEEL_WIRES, 0.06, 167.0) == pytest.approx(0.2580, abs=1e-4)
    assert slip_amplitude(STEEL_WIRES, 0.06, 167.0) == pytest.approx(0.05207, abs=1e-5)
    assert dissipated_energy(STEEL_WIRES, 0.06) == pytest.approx(0.2949, abs=1e-4)
    assert slip_amplitude(STEEL_WIRES, 0.06) == pytest.approx(0.05949, abs=1e-5)


@given(STIFFNESSES, st.floats(0.05, 20.0))
def test_energy_and_slip_are_the_loops_area_and_half_width(rig: float, excess: float) -> None:
    amplitude = excess * sliding_threshold(STEEL_WIRES, rig)
    path = amplitude * -np.cos(np.linspace(0.0, math.pi, 4001))
    forward = branch_force(STEEL_WIRES, path, amplitude, rig, forward=True)
    backward = branch_force(STEEL_WIRES, path, amplitude, rig, forward=False)
    area = float(np.trapezoid(forward - backward, path))
    assert dissipated_energy(STEEL_WIRES, amplitude, rig) == pytest.approx(area, rel=2e-4)
    half_width = 0.5 * (np.interp(0.0, backward, path) - np.interp(0.0, forward, path))
    assert slip_amplitude(STEEL_WIRES, amplitude, rig) == pytest.approx(half_width, rel=1e-3)


@given(STIFFNESSES, st.floats(0.0, 1.0))
def test_the_spring_and_the_contact_share_the_displacement(rig: float, ratio: float) -> None:
    force = ratio * STEEL_WIRES.limit_N
    displacement = force / rig + float(loading_displacement(STEEL_WIRES, force))
    assert float(first_loading_force(STEEL_WIRES, displacement, rig)) == pytest.approx(force, abs=1e-7)


@given(STIFFNESSES, st.floats(0.1, 10.0))
def test_a_branch_leaves_its_reversal_with_the_series_stiffness(rig: float, excess: float) -> None:
    amplitude = excess * sliding_threshold(STEEL_WIRES, rig)
    step = 1e-5 * sliding_threshold(STEEL_WIRES, rig)
    ends = branch_force(STEEL_WIRES, [amplitude, amplitude - step], amplitude, rig, forward=False)
    slope = (ends[0] - ends[1]) / step
    assert slope == pytest.approx(unloading_stiffness(STEEL_WIRES, rig), rel=1e-4)


@given(STIFFNESSES, st.floats(0.1, 10.0), st.integers(8, 200))
def test_a_closed_loop_lies_on_its_branches_and_is_point_symmetric(rig: float, excess: float, quarters: int) -> None:
    amplitude = excess * sliding_threshold(STEEL_WIRES, rig)
    loop = closed_loop(STEEL_WIRES, amplitude, rig, 4 * quarters)
    half = 2 * quarters
    assert loop.displacement_mm[0] == 0.0
    assert loop.displacement_mm[1] > 0.0
    np.testing.assert_allclose(loop.tangential_force_N[half:], -loop.tangential_force_N[:half], atol=1e-9)
    assert np.abs(loop.tangential_force_N).max() <= STEEL_WIRES.limit_N * (1.0 + 1e-12)
    first_half = branch_force(STEEL_WIRES, loop.displacement_mm[:quarters], amplitude, rig, forward=True)
    np.testing.assert_allclose(loop.tangential_force_N[:quarters], first_half)


def test_a_stiff_rig_recovers_the_rigid_loop() -> None:
    stiff, rigid = closed_loop(STEEL_WIRES, 0.06, 1e9), closed_loop(STEEL_WIRES, 0.06)
    np.testing.assert_allclose(stiff.tangential_force_N, rigid.tangential_force_N, atol=1e-5)


def test_a_loop_of_too_few_samples_is_refused() -> None:
    with pytest.raises(ValueError, match="samples must be at least 8"):
        closed_loop(STEEL_WIRES, 0.06, samples=4)
    with pytest.raises(ValueError, match="rig_stiffness_N_per_mm must be positive"):
        sliding_threshold(STEEL_WIRES, 0.0)
    with pytest.raises(ValueError, match="friction must be positive"):
        PartialSlipPoint(2.0, 0.0, 0.01, 1.0)


@given(st.floats(1e-7, 1e-2), st.floats(0.05, 10.0))
def test_the_worn_volume_is_the_overlap_of_the_two_wires(volume_mm3: float, radius_mm: float) -> None:
    scar = crossed_wire_scar(volume_mm3, radius_mm)
    r = np.linspace(0.0, scar.radius_mm, 4001)
    overlap = np.trapezoid((scar.depth_mm - r**2 / (2 * radius_mm)) * 2 * math.pi * r, r)
    assert overlap == pytest.approx(volume_mm3, rel=1e-5)
    assert worn_pressure(2.0, scar) * math.pi * scar.radius_mm**2 == pytest.approx(2.0)


def test_the_worn_area_of_a_cylinder_is_its_overlap_with_the_flat() -> None:
    scar: LineScar = line_contact_scar(1e-3, 6.0)
    x = np.linspace(-scar.half_width_mm, scar.half_width_mm, 4001)
    assert np.trapezoid(scar.depth_mm - x**2 / 12.0, x) == pytest.approx(1e-3, rel=1e-5)


def test_depth_grows_as_the_square_root_for_wires_and_the_two_thirds_power_for_a_line() -> None:
    assert crossed_wire_scar(4e-5, 0.2).depth_mm / crossed_wire_scar(1e-5, 0.2).depth_mm == pytest.approx(2.0)
    assert line_contact_scar(8e-5, 0.2).depth_mm / line_contact_scar(1e-5, 0.2).depth_mm == pytest.approx(4.0)
    assert worn_volume(3e-5, 2000.0) == pytest.approx(6e-5)


def amplification(cycles: float, wave_number: float, h_mm: float) -> float:
    """Growth factor of a pressure ripple on a line of nodes, from a discrete half-plane influence in Fourier space."""
    depth_per_cycle_and_pressure = 3e-8 * 0.62 * 0.208
    return 1.0 - cycles * depth_per_cycle_and_pressure * 115385.0 * wave_number / (2.0 * h_mm)


@pytest.mark.parametrize(("plane", "wave_number"), [(True, math.pi), (False, math.pi * math.sqrt(2.0))])
def test_the_explicit_limit_is_where_the_shortest_ripple_flips_without_decay(plane: bool, wave_number: float) -> None:
    limit = explicit_stability_limit(0.005, 3e-5, 0.62, 115385.0, 0.208, plane=plane)
    assert amplification(limit, wave_number, 0.005) == pytest.approx(-1.0)
    assert 10.0 < limit < 14.3
