"""Plane strain by the same code: elasticity, contact and friction of planar bodies."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from geometry import Cylinder, Elastic, Flat, GradedAxis, PlanarGeometry, build_planar
from solvers import (
    ContactProblem,
    ContactState,
    Holder,
    PlacedBody,
    WearRates,
    advance,
    condense,
    place,
    press,
    unloaded_state,
)
from solvers.elasticity import stiffness_matrix
from solvers.pairing import pair, primary_surface
from wirewear import reference
from wirewear.verification.line_contact import (
    FRICTION,
    MATERIAL,
    LOAD_N_per_mm,
    RADIUS_mm,
    cylinder_on_flat,
    half_width,
    tangential_force,
)

E, NU = 200_000.0, 0.3
STEEL = Elastic(E, NU)
HERTZ = reference.hertz_line(LOAD_N_per_mm, RADIUS_mm, reference.contact_modulus(MATERIAL, MATERIAL))


def block(fine_mm: float, half_mm: float = 0.5, height_mm: float = 1.0, *, upper: bool = False) -> PlacedBody:
    along = GradedAxis(fine_mm, 0.5 * half_mm, fine_mm, 0.98 * half_mm)
    meshed = build_planar(PlanarGeometry(Flat(), half_mm, height_mm, along, far_mm=0.2))
    return place(condense(meshed.mesh, meshed.patch, STEEL), upper=upper, axis_angle_rad=0.0)


@cache
def line_contact() -> tuple[ContactProblem, ContactState]:
    problem = cylinder_on_flat(HERTZ.half_width_mm / 10.0)
    return problem, press(problem, unloaded_state(problem))[0]


def test_uniform_strain_is_reproduced_in_plane_and_out_of_it() -> None:
    mesh = build_planar(
        PlanarGeometry(Cylinder(6.0, curved_along=True), 1.0, 1.0, GradedAxis(0.1, 0.2, 0.1, 0.5), far_mm=0.2)
    ).mesh
    stiffness = stiffness_matrix(mesh, STEEL)
    x, z = mesh.points.T
    strain = np.array([[3e-4, 2e-4, 0.0], [0.0, 5e-4, 0.0], [1e-4, -4e-4, 0.0]])
    displacement = np.column_stack([a * x + b * z for a, b, _ in strain])
    force = (stiffness @ displacement.ravel()).reshape(-1, 3)
    edges = np.concatenate([mesh.surfaces["contact"], mesh.surfaces["grip"], mesh.surfaces["sides"]])
    inner = np.setdiff1d(np.arange(len(x)), [*edges.ravel(), *np.flatnonzero(np.abs(x) > 0.49)])
    assert np.abs(force[inner]).max() < 1e-10 * np.abs(force).max()
    # The energy of a state of uniform stress is its density times the area; plane strain means eps_yy = 0.
    (exx, exz), (uyx, uyz), (ezx, ezz) = strain[:, :2]
    shear, lame = E / (2.0 * (1.0 + NU)), E * NU / ((1.0 + NU) * (1.0 - 2.0 * NU))
    density = 0.5 * lame * (exx + ezz) ** 2 + shear * (exx**2 + ezz**2 + 0.5 * ((exz + ezx) ** 2 + uyx**2 + uyz**2))
    assert 0.5 * displacement.ravel() @ force.ravel() == pytest.approx(density * mesh.area_mm2(), rel=1e-10)


def test_displacements_out_of_the_plane_decouple_from_those_in_it() -> None:
    compliance = block(0.1).compliance
    size = len(compliance) // 3
    coupled = compliance.reshape(size, 3, size, 3)[:, [0, 2]][:, :, :, 1]
    assert np.abs(coupled).max() < 1e-15 * np.abs(compliance).max()
    assert np.linalg.eigvalsh(compliance).min() > 0.0


@pytest.mark.parametrize("primary_is_upper", [True, False])
def test_uniform_pressure_crosses_planar_meshes_that_do_not_match(primary_is_upper: bool) -> None:
    upper, lower = block(0.05, upper=True), block(0.07)
    primary, secondary = (upper, lower) if primary_is_upper else (lower, upper)
    nodes = np.flatnonzero(np.abs(primary.patch.axial_mm) < 0.42)
    fresh = [np.zeros(b.patch.shape) for b in (primary, secondary)]
    pairing = pair(primary_surface(primary), secondary, nodes, np.array([0.003, 0.0]), fresh[0], fresh[1])
    force = pairing.secondary.T @ np.ones(len(nodes))
    assert force.sum() == pytest.approx(pairing.areas.sum(), rel=1e-12)
    whole = np.abs(secondary.patch.axial_mm) < 0.35
    assert force[whole] == pytest.approx(secondary.patch.node_areas()[whole], rel=0.1)


def test_a_cylinder_on_a_flat_is_hertzs_line_contact() -> None:
    problem, pressed = line_contact()
    assert pressed.primary_force[:, 2].sum() == pytest.approx(LOAD_N_per_mm, rel=1e-9)
    assert pressed.traction[:, 2].max() == pytest.approx(HERTZ.peak_pressure_MPa, rel=0.01)
    assert half_width(problem, pressed.traction[:, 2]) == pytest.approx(HERTZ.half_width_mm, rel=0.01)


def test_the_roles_of_both_planar_bodies_may_be_swapped() -> None:
    problem, pressed = line_contact()
    swapped = replace(problem, primary_is_upper=False)
    other = press(swapped, unloaded_state(swapped))[0]
    assert other.holder_z == pytest.approx(pressed.holder_z, rel=2e-3)
    assert half_width(swapped, other.traction[:, 2]) == pytest.approx(half_width(problem, pressed.traction[:, 2]), 0.01)


def test_mirrored_planar_motion_gives_exactly_the_mirrored_forces() -> None:
    problem, pressed = line_contact()
    one, other = pressed, pressed
    for drive in (0.0006, 0.0012, 0.0030, 0.0050, 0.0044, 0.0030):
        one, other = advance(problem, one, drive, 0.0)[0], advance(problem, other, -drive, 0.0)[0]
        assert tangential_force(other) == pytest.approx(-tangential_force(one), rel=1e-9)
        mirrored = other.traction[::-1] * [-1.0, 1.0, 1.0]
        assert mirrored == pytest.approx(one.traction, abs=1e-6 * HERTZ.peak_pressure_MPa)
    assert not one.traction[:, 1].any()


def test_a_contact_in_partial_slip_repeats_itself_from_the_second_cycle_on() -> None:
    problem, state = line_contact()
    stroke = 0.0012 * np.cos(2.0 * np.pi * np.arange(-4, 1) / 16)
    cycle = 0.0012 * np.cos(2.0 * np.pi * np.arange(1, 17) / 16)
    ends = []
    for drive in (*stroke, *cycle, *cycle, *cycle):
        state = advance(problem, state, float(drive), 0.0)[0]
        if drive == cycle[-1]:
            ends.append(state)
    assert abs(tangential_force(state)) < 0.9 * FRICTION * LOAD_N_per_mm
    creep = ends[-1].traction - ends[-2].traction
    assert np.abs(creep).max() < 1e-4 * FRICTION * HERTZ.peak_pressure_MPa


def test_full_slip_of_a_planar_contact_carries_friction_times_load() -> None:
    problem, state = line_contact()
    for drive in (0.003, 0.006, 0.009):
        state, _ = advance(problem, state, drive, 0.0)
    assert abs(tangential_force(state)) == pytest.approx(FRICTION * LOAD_N_per_mm, rel=1e-3)


def test_a_planar_contact_wears_alpha_times_energy_on_each_body() -> None:
    problem, state = line_contact()
    worn = replace(problem, wear=WearRates(3e-8, 1e-8), holder=Holder(LOAD_N_per_mm, 1.0 / 5e4))
    for drive in (0.01, 0.02, 0.01, -0.01, -0.02):
        state, _ = advance(worn, state, drive, 2000.0)
    energy = state.wear.energy_mJ
    assert energy > 0.0
    upper = worn.upper.patch.node_areas() @ state.wear.primary_depth.ravel()
    lower = worn.lower.patch.node_areas() @ state.wear.secondary_depth.ravel()
    assert upper == pytest.approx(3e-8 * energy, rel=1e-9)
    assert lower == pytest.approx(1e-8 * energy, rel=1e-9)
