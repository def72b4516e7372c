"""Estimates of contacts of strands: stresses and energy of a line along which wires slide, lives."""

from math import inf, isinf, pi

import numpy as np
import pytest

from geometry import Elastic
from tests.strand.ropes import seven_wires
from wirewear import strand_contacts
from wirewear.strand.estimates import _antiplane, _partial_line_mJ, estimated
from wirewear.stress.criteria import criterion_of
from wirewear.test.life import LifeTable

STEEL = Elastic(200_000.0, 0.3)
LIFE = LifeTable(averaging_length_um=20.0, tensile_strength_MPa=1960.0)


def test_shear_along_a_line_is_in_balance_and_vanishes_beside_it() -> None:
    """τ_yz and τ_xy are each other's conjugate: d τ_xy/dx + d τ_yz/dz = 0, and strains fit together."""
    x, z, h = np.array([0.3, 1.4, -0.7, -2.0]), np.array([0.2, 0.5, 1.1, 0.3]), 1e-6
    by_x = (_antiplane(x + h, z, 1.0) - _antiplane(x - h, z, 1.0)) / (2.0 * h)
    by_z = (_antiplane(x, z + h, 1.0) - _antiplane(x, z - h, 1.0)) / (2.0 * h)
    assert np.abs(by_x.imag + by_z.real).max() < 1e-8
    assert np.abs(by_x.real - by_z.imag).max() < 1e-8
    surface = np.array([0.0, 0.6, 1.5, -1.5])
    assert _antiplane(surface, np.full(4, 1e-14), 1.0).real == pytest.approx([-1.0, -0.8, 0.0, 0.0], abs=1e-6)
    assert abs(_antiplane(np.array([0.0]), np.array([1e3]), 1.0)[0]) < 1e-3


def test_a_line_about_to_slide_dissipates_its_closed_form() -> None:
    """Slip q0 x²/(2a) (1/G₁ + 1/G₂) under q0 √(1 − x²/a²): a cycle takes q0² a² π/4 of that compliance."""
    compliance = 2.0 / STEEL.shear_modulus_MPa
    found = _partial_line_mJ(0.03, 300.0, 1.0, STEEL, STEEL)
    assert found == pytest.approx(300.0**2 * 0.03**2 * 0.25 * pi * compliance, rel=1e-3)
    assert 0.0 < _partial_line_mJ(0.03, 300.0, 0.5, STEEL, STEEL) < 0.1 * found
    assert _partial_line_mJ(0.03, 300.0, 0.0, STEEL, STEEL) == 0.0


def test_without_friction_a_life_is_that_of_the_bulk_stress_less_some_mean() -> None:
    tables = seven_wires(3.12, 60, friction=0.0)
    tables["conditions"]["bending_radius_mm"] = 250.0
    contact = strand_contacts(tables).contacts[0].contact
    found = estimated(contact, 0.0, 0.0, 1, LIFE)
    wire = contact.upper
    pulled = np.zeros((2, 1, 6))
    pulled[:, 0, 1] = wire.mean_MPa + wire.amplitude_MPa * np.array([1.0, -1.0])
    alone = 1.0 / criterion_of(LIFE.of_material(None), wire.wire.elastic).damage(pulled).share[0]
    # The steady pressure at the edge presses along the wire, too, and so takes off its mean.
    assert alone < found.lives[1] < 4.0 * alone


def test_friction_shortens_lives_and_the_life_of_a_contact_is_the_shorter_of_both_wires() -> None:
    contact = strand_contacts(seven_wires(3.12, 60)).contacts[0].contact
    lives = [estimated(contact, friction, 0.0, 1, LIFE).life_cycles for friction in (0.15, 0.4, 0.8)]
    assert inf > lives[0] > lives[1] > lives[2] > 0.0
    both = estimated(contact, 0.4, 0.0, 1, LIFE)
    assert both.life_cycles == min(both.lives)
    assert not isinf(both.lives[1])


def test_no_life_is_estimated_unless_asked_for() -> None:
    one = strand_contacts(seven_wires(3.12, 60)).contacts[0]
    assert np.isnan(one.life_cycles)
    assert strand_contacts(seven_wires(3.12, 60)).rows[0]["life_upper_cycles"] is None
