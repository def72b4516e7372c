"""Two contacts near each other on one wire: both patches on one factored matrix, against a run each and the wire."""

from dataclasses import dataclass
from math import pi

import numpy as np
import pytest
from scipy.optimize import root

from geometry import ContactPatch, Cylinder, WireGeometry, build_body
from geometry.arrays import Array
from solvers.contact import ContactProblem, press, unloaded_state
from solvers.contact_state import Holder
from solvers.elasticity.bar import Bar
from solvers.elasticity.condensation import CondensedBody, condense
from solvers.elasticity.placement import place
from solvers.wear import WearRates
from tests.bodies import STEEL, DIAMETER_mm, RADIUS_mm, condensed_wire, wire_geometry
from wirewear.sweeps.beam import Beam

LOAD_N = 4.0
ONE = wire_geometry(0.01, 0.02, 0.04)


@dataclass(frozen=True)
class AboutTwo:
    """Mesh lines that are fine about two places, at_mm to either side of the middle."""

    at_mm: float
    finest_mm: float = 0.01

    @property
    def half_extent_mm(self) -> float:
        return self.at_mm + 0.04

    def half_lines(self) -> Array:
        own = self.at_mm + ONE.axial.lines()
        return np.concatenate([np.linspace(0.0, own[0], max(2, round(own[0] / 0.05) + 1))[:-1], own])

    def lines(self) -> Array:
        return np.concatenate([-self.half_lines()[:0:-1], self.half_lines()])


@dataclass(frozen=True)
class TwoWires(Cylinder):
    """Two wires beside each other, one of them lower."""

    at_mm: float = 0.0
    lower_mm: float = 0.0

    def height(self, plane_mm: Array) -> Array:
        own = plane_mm - [0.0, self.at_mm] * np.sign(plane_mm)
        return super().height(own) - np.where(plane_mm[:, 1] > 0.0, self.lower_mm, 0.0)

    def slope(self, plane_mm: Array) -> Array:
        return super().slope(plane_mm - [0.0, self.at_mm] * np.sign(plane_mm))

    def require_within(self, along_mm: float, across_mm: float) -> None: ...


def pressed(held: CondensedBody, driven: CondensedBody, load_N: float) -> tuple[Array, float, float]:
    """Loads (2,) to either side of the middle, approach, and largest pressure."""
    upper, lower = place(held, upper=True, axis_angle_rad=pi / 2), place(driven, upper=False, axis_angle_rad=0.0)
    problem = ContactProblem(upper, lower, Holder(load_N, 0.0), 0.0, WearRates(0.0, 0.0))
    state, report = press(problem, unloaded_state(problem))
    side = problem.primary.node_positions[:, 1] > 0.0
    loads = np.array([state.primary_force[own, 2].sum() for own in (~side, side)])
    return loads, -state.holder_z, report.max_pressure


def both(apart: float, lower_mm: float, between_ends_mm: float = 0.0) -> tuple[Array, float, float]:
    """Two driven wires under one, so many diameters apart; that is held at its ends, or on its back."""
    at, one = 0.5 * apart * DIAMETER_mm, condensed_wire(0.01)
    length = between_ends_mm or 2.5 * (at + 0.04) + DIAMETER_mm
    sizes = DIAMETER_mm, length, AboutTwo(at), ONE.transverse, 0.12
    held = build_body(WireGeometry(*sizes, gripped_at_ends=between_ends_mm > 0.0))  # type: ignore[arg-type]
    lines, nodes = one.patch.transverse_mm, np.arange(2 * one.patch.size).reshape(len(one.patch.axial_mm), -1)
    beside = np.concatenate([lines - at, lines + at])
    patch = ContactPatch(one.patch.axial_mm, beside, nodes, TwoWires(RADIUS_mm, at_mm=at, lower_mm=lower_mm))
    matrix = np.zeros((6 * one.patch.size, 6 * one.patch.size))
    for own in np.split(nodes, 2, axis=1):
        unknowns = (3 * own.reshape(-1, 1) + np.arange(3)).ravel()
        matrix[np.ix_(unknowns, unknowns)] = one.compliance
    return pressed(condense(held.mesh, held.patch, STEEL), CondensedBody.whole(patch, matrix), LOAD_N)


@pytest.mark.slow
@pytest.mark.parametrize(("apart", "felt"), [(0.5, 0.01), (1.0, 0.002), (2.0, 0.001)])
def test_contacts_half_a_diameter_apart_or_more_are_two_runs(apart: float, felt: float) -> None:
    loads, approach, pressure = both(apart, 0.0)
    _, single, peak = pressed(condensed_wire(0.01), condensed_wire(0.01), 0.5 * LOAD_N)
    np.testing.assert_allclose(loads, 0.5 * LOAD_N, rtol=1e-9)
    assert pressure == pytest.approx(peak, rel=1e-4)
    assert approach == pytest.approx(single, rel=felt)


def shared(apart: float, lower_mm: float, wire: Beam | Bar, alone: Array, loads: Array, backing: float) -> Array:
    """Loads (2,) by a wire held at its ends, of contacts whose approaches are `alone` (2,) under `loads` (2,)."""
    stiffness, _ = wire.at(np.array([-0.5, 0.5]) * apart * DIAMETER_mm)

    def missed(unknowns: Array) -> list[float]:
        force, pushed = unknowns[:2], 1e-3 * unknowns[2]
        sunk = alone * (force / loads) ** (2.0 / 3.0) - backing * force
        return [*(force - stiffness @ (pushed - np.array([0.0, lower_mm]) - sunk)), force.sum() - LOAD_N]

    return np.asarray(root(missed, [2.0, 2.0, 2.0]).x[:2])


@pytest.mark.slow
@pytest.mark.parametrize(("apart", "lower_um"), [(0.5, 0.15), (1.0, 0.3), (2.0, 0.6), (4.0, 1.2)])
def test_near_contacts_share_the_load_of_a_wire_held_at_its_ends_as_both_at_once_do(
    apart: float, lower_um: float
) -> None:
    """One of both lies lower. The ends are pushed towards the contacts; the beam is the wire's axis."""
    length, lower = (apart + 6.0) * DIAMETER_mm, 1e-3 * lower_um
    loads, _, _ = both(apart, lower, length)
    assert loads.sum() == pytest.approx(LOAD_N, rel=1e-9)
    one, ends = condensed_wire(0.01), (-0.5 * length, 0.5 * length)
    alone = np.array([pressed(one, one, load)[1] for load in loads])
    bar = Bar(LOAD_N, (0.0,), 0.0, ends, RADIUS_mm, 0.0, STEEL, pi / 4)
    # Between far contacts, what the bricks of the reference lack in bending adds up.
    felt = 0.003 if apart < 4.0 else 0.015
    np.testing.assert_allclose(shared(apart, lower, bar, alone, loads, 0.0), loads, rtol=felt)
    bending = STEEL.youngs_modulus_MPa * pi / 64.0 * DIAMETER_mm**4
    beam = Beam(bending, 0.886 * STEEL.shear_modulus_MPa * pi / 4.0 * DIAMETER_mm**2, LOAD_N, (0.0,), 0.0, ends)
    backing = 1.56 / (STEEL.youngs_modulus_MPa * DIAMETER_mm)
    np.testing.assert_allclose(shared(apart, lower, beam, alone, loads, backing), loads, rtol=0.03)


@pytest.mark.seconds
@pytest.mark.parametrize("bore", [0.0, 0.2])
def test_forces_of_near_contacts_balance_and_do_not_resist_rigid_motions(bore: float) -> None:
    places = np.array([-0.5, 0.0, 0.5]) * DIAMETER_mm
    stiffness, force = Bar(LOAD_N, (0.1,), 0.0, (), RADIUS_mm, bore, STEEL, pi / 4).at(places)
    np.testing.assert_allclose(stiffness, stiffness.T, atol=1e-7 * stiffness.max())
    for motion in (np.ones(3), places / DIAMETER_mm):
        np.testing.assert_allclose(stiffness @ motion, 0.0, atol=1e-7 * stiffness.max())
    assert force.sum() == pytest.approx(LOAD_N, rel=1e-8)
    assert force @ places == pytest.approx(0.1 * LOAD_N, rel=1e-8)


@pytest.mark.parametrize(
    ("places", "loads", "clamped", "tension_N"),
    [((-4.0, 0.0, 4.0), (0.0,), (), 0.0), ((-4.0, 0.0, 4.0), (0.0,), (), 300.0), ((12.0, 8.0), (16.0,), (0.0,), 600.0)],
)
@pytest.mark.slow
def test_elements_of_a_wire_share_loads_between_far_contacts_as_timoshenkos_beam(
    places: tuple[float, ...], loads: tuple[float, ...], clamped: tuple[float, ...], tension_N: float
) -> None:
    """A wire of 1 mm on springs, so many millimetres apart."""
    acts, at, soft = (6.0, loads, tension_N, clamped), np.array(places), np.eye(len(places)) / 2000.0
    shear = 0.886 * STEEL.shear_modulus_MPa * pi / 4.0
    found = []
    for wire, own in (
        (Bar(*acts, 0.5, 0.0, STEEL, pi / 4), soft),
        (Beam(STEEL.youngs_modulus_MPa * pi / 64.0, shear, *acts), soft - np.eye(len(at)) * 1.56 / 210_000.0),
    ):
        stiffness, force = wire.at(at)
        found.append(np.linalg.solve(np.eye(len(at)) + stiffness @ own, force))
    np.testing.assert_allclose(found[0], found[1], atol=0.003 * 6.0)
