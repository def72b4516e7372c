"""Two contacts near each other on one wire: both patches on one factored matrix, against a run each and the beam."""

from dataclasses import dataclass
from functools import cache
from math import pi

import numpy as np
import pytest
from scipy.optimize import root

from geometry import ContactPatch, Cylinder, WireGeometry, build_body
from geometry.arrays import Array
from solvers.contact import ContactProblem, press, unloaded_state
from solvers.contact_state import ContactState, Holder, IncrementReport
from solvers.elasticity.condensation import CondensedBody, condense
from solvers.elasticity.placement import place
from solvers.wear import WearRates
from tests.bodies import DIAMETER_mm, RADIUS_mm, STEEL, condensed_wire, wire_geometry
from wirewear.sweeps.beam import Beam

LOAD_N, LOWER_mm, FINE_mm = 4.0, 3e-4, 0.01  # One of both wires lies 0.3 µm lower.


@dataclass(frozen=True)
class AboutTwo:
    """Mesh lines that are fine about two places, at_mm to either side of the middle."""

    at_mm: float
    finest_mm: float = FINE_mm

    @property
    def half_extent_mm(self) -> float:
        return self.at_mm + 0.04

    def half_lines(self) -> Array:
        own = self.at_mm + wire_geometry(FINE_mm, 0.02, 0.04).axial.lines()
        return np.concatenate([np.linspace(0.0, own[0], max(2, round(own[0] / 0.05) + 1))[:-1], own])

    def lines(self) -> Array:
        return np.concatenate([-self.half_lines()[:0:-1], self.half_lines()])


@dataclass(frozen=True)
class TwoWires(Cylinder):
    """Two wires beside each other, one of them lower."""

    at_mm: float = 0.0
    lower_mm: float = 0.0

    def height(self, plane_mm: Array) -> Array:
        return super().height(self._own(plane_mm)) - np.where(plane_mm[:, 1] > 0.0, self.lower_mm, 0.0)

    def slope(self, plane_mm: Array) -> Array:
        return super().slope(self._own(plane_mm))

    def require_within(self, along_mm: float, across_mm: float) -> None: ...

    def _own(self, plane_mm: Array) -> Array:
        return plane_mm - np.array([[0.0, 1.0]]) * np.sign(plane_mm[:, 1:]) * self.at_mm


def pressed(held: CondensedBody, driven: CondensedBody, load_N: float) -> tuple[ContactState, IncrementReport, Array]:
    """The state, its report, and the loads (2,) to either side of the middle."""
    upper, lower = place(held, upper=True, axis_angle_rad=pi / 2), place(driven, upper=False, axis_angle_rad=0.0)
    problem = ContactProblem(upper, lower, Holder(load_N, 0.0), 0.0, WearRates(0.0, 0.0))
    state, report = press(problem, unloaded_state(problem))
    side = problem.primary.node_positions[:, 1] > 0.0
    return state, report, np.array([state.primary_force[own, 2].sum() for own in (~side, side)])


@cache
def alone() -> tuple[ContactState, IncrementReport, Array]:
    return pressed(condensed_wire(FINE_mm), condensed_wire(FINE_mm), 0.5 * LOAD_N)


def both(apart: float, lower_mm: float, held_at_ends_mm: float = 0.0) -> tuple[ContactState, IncrementReport, Array]:
    """Two driven wires under one, so many diameters apart; that is held at its ends, or on its back."""
    at, one = 0.5 * apart * DIAMETER_mm, condensed_wire(FINE_mm)
    length = held_at_ends_mm or 2.5 * (at + 0.04) + DIAMETER_mm
    across = wire_geometry(FINE_mm, 0.02, 0.04).transverse
    held = build_body(
        WireGeometry(DIAMETER_mm, length, AboutTwo(at), across, 0.12, gripped_at_ends=held_at_ends_mm > 0.0)  # type: ignore[arg-type]
    )
    along, lines = one.patch.axial_mm, one.patch.transverse_mm
    patch = ContactPatch(
        along,
        np.concatenate([lines - at, lines + at]),
        np.arange(2 * one.patch.size).reshape(len(along), -1),
        TwoWires(RADIUS_mm, at_mm=at, lower_mm=lower_mm),
    )
    shape = len(along), len(lines), 3
    matrix = np.zeros((shape[0], 2, *shape[1:], shape[0], 2, *shape[1:]))
    for side in (0, 1):
        matrix[:, side, :, :, :, side] = one.compliance.reshape(shape * 2)
    driven = CondensedBody.whole(patch, matrix.reshape(6 * one.patch.size, -1))
    return pressed(condense(held.mesh, held.patch, STEEL), driven, LOAD_N)


@pytest.mark.slow
@pytest.mark.parametrize(("apart", "felt"), [(0.5, 0.01), (1.0, 0.0015), (2.0, 0.0003)])
def test_contacts_a_diameter_apart_are_two_runs_and_nearer_ones_feel_each_other(apart: float, felt: float) -> None:
    state, report, loads = both(apart, 0.0)
    lone, single, _ = alone()
    np.testing.assert_allclose(loads, 0.5 * LOAD_N, rtol=1e-9)
    assert report.max_pressure == pytest.approx(single.max_pressure, rel=1e-4)
    assert 0.0 < state.holder_z / lone.holder_z - 1.0 < felt


@pytest.mark.slow
@pytest.mark.parametrize("apart", [1.0, 2.0])
def test_near_contacts_share_the_load_of_a_wire_held_at_its_ends_as_on_a_beam(apart: float) -> None:
    length = (apart + 6.0) * DIAMETER_mm
    _, _, loads = both(apart, LOWER_mm, length)
    assert loads.sum() == pytest.approx(LOAD_N, rel=1e-9)
    bending = STEEL.youngs_modulus_MPa * pi / 64.0 * DIAMETER_mm**4
    shear = 0.886 * STEEL.shear_modulus_MPa * pi / 4.0 * DIAMETER_mm**2
    at = 0.5 * apart * DIAMETER_mm
    beam = Beam(bending, shear, LOAD_N, (0.0,), clamped_at_mm=(-0.5 * length, 0.5 * length))
    stiffness, _ = beam.at(np.array([-at, at]))
    softness = -alone()[0].holder_z / (0.5 * LOAD_N) ** (2.0 / 3.0)

    def missed(unknowns: Array) -> list[float]:
        force, down = unknowns[:2], 1e-3 * unknowns[2] - np.array([0.0, LOWER_mm]) - softness * unknowns[:2] ** (2 / 3)
        return [*(force - stiffness @ down), force.sum() - LOAD_N]

    np.testing.assert_allclose(root(missed, [2.0, 2.0, 2.0]).x[:2], loads, rtol=0.02)
