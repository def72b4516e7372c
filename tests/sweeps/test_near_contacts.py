"""Two contacts near each other on one wire: both patches on one factored matrix, against a run each and the beam."""

from dataclasses import dataclass
from math import pi

import numpy as np
import pytest
from scipy.optimize import root

from geometry import ContactPatch, Cylinder, WireGeometry, build_body
from geometry.arrays import Array
from solvers.contact import ContactProblem, press, unloaded_state
from solvers.contact_state import Holder
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


@pytest.mark.slow
@pytest.mark.parametrize(("apart", "lower_um"), [(0.5, 0.15), (1.0, 0.3), (2.0, 0.6), (4.0, 1.2)])
def test_near_contacts_share_the_load_of_a_wire_held_at_its_ends_as_on_a_beam(apart: float, lower_um: float) -> None:
    """One of both lies lower. The ends are pushed towards the contacts; the beam is the wire's axis."""
    length, at, lower = (apart + 6.0) * DIAMETER_mm, 0.5 * apart * DIAMETER_mm, 1e-3 * lower_um
    loads, _, _ = both(apart, lower, length)
    assert loads.sum() == pytest.approx(LOAD_N, rel=1e-9)
    bending = STEEL.youngs_modulus_MPa * pi / 64.0 * DIAMETER_mm**4
    shear = 0.886 * STEEL.shear_modulus_MPa * pi / 4.0 * DIAMETER_mm**2
    beam = Beam(bending, shear, LOAD_N, (0.0,), clamped_at_mm=(-0.5 * length, 0.5 * length))
    stiffness, _ = beam.at(np.array([-at, at]))
    _, single, _ = pressed(condensed_wire(0.01), condensed_wire(0.01), 0.5 * LOAD_N)
    backing = 1.56 / (STEEL.youngs_modulus_MPa * DIAMETER_mm)

    def missed(unknowns: Array) -> list[float]:
        force, pushed = unknowns[:2], 1e-3 * unknowns[2]
        sunk = single * (force / (0.5 * LOAD_N)) ** (2.0 / 3.0) - backing * force
        down = pushed - np.array([0.0, lower]) - sunk
        return [*(force - stiffness @ down), force.sum() - LOAD_N]

    np.testing.assert_allclose(root(missed, [2.0, 2.0, 2.0]).x[:2], loads, rtol=0.02)
