"""Temperatures in cycle jumps: what rubs warms, and wear, friction and oxygen follow it."""

from dataclasses import replace
from functools import cache
from math import exp, pi, sqrt

import numpy as np
import pytest

import solvers
from geometry.arrays import Array
from solvers.laws.heat import GAS_CONSTANT
from tests.bodies import FRICTION
from tests.solvers.wear_jumps import RATES, at_the_end, jumped, line_contact, wires

pytestmark = pytest.mark.seconds
STROKE_mm = 0.012
#: Through so large a resistance all of the surface is as warm.
THROUGH = solvers.Conductor(46e6, 3.6, 3000.0)
STEEL = solvers.Conductor(46.0, 3.6)
FREQUENCY_Hz = solvers.DriveTiming().frequency_Hz
ENERGY_J_per_mol = 40e3


@cache
def worn(
    heat: solvers.FrictionHeat | None,
    *jumps: float,
    oxygen: solvers.OxygenSupply | None = None,
    friction: float = FRICTION,
) -> solvers.WearState:
    """A line contact after some jumps."""
    contact = replace(line_contact(wear=solvers.WearRates(*RATES, heat=heat, oxygen=oxygen)), friction=friction)
    state = at_the_end(contact, STROKE_mm)
    for cycles in jumps:
        state = jumped(contact, state, cycles, stroke_mm=STROKE_mm).state
    return state.wear


def rises_of(wear: solvers.WearState) -> tuple[Array, Array]:
    assert wear.rises is not None
    return wear.rises


def arrhenius(energy_J_per_mol: float, rise_K: float) -> float:
    return exp(energy_J_per_mol / GAS_CONSTANT * (1.0 / 293.15 - 1.0 / (293.15 + rise_K)))


def test_all_friction_work_of_a_cycle_becomes_heat() -> None:
    heated = worn(solvers.FrictionHeat(THROUGH, THROUGH), 1e-3)
    power_W = 1e-3 * heated.energy_mJ / 1e-3 * FREQUENCY_Hz
    assert heated.rise_K == pytest.approx(0.5 * 3000.0 * power_W, rel=1e-6)
    assert rises_of(heated)[0] == pytest.approx(rises_of(heated)[1].max(), rel=1e-6)


def test_an_even_temperature_changes_wear_by_the_ratio_of_arrhenius() -> None:
    heated = worn(solvers.FrictionHeat(THROUGH, THROUGH, wear_J_per_mol=ENERGY_J_per_mol), 1e-3)
    assert heated.rise_K > 2.0
    for volume, rate in zip((heated.primary_volume_mm3, heated.secondary_volume_mm3), RATES, strict=True):
        ratio = volume / (rate * heated.energy_mJ)
        assert ratio == pytest.approx(arrhenius(ENERGY_J_per_mol, heated.rise_K), rel=1e-6)


def test_temperatures_that_change_nothing_change_nothing() -> None:
    cold, heated = worn(None, 100.0, 200.0), worn(solvers.FrictionHeat(STEEL, STEEL), 100.0, 200.0)
    assert (cold.primary_depth == heated.primary_depth).all()
    assert cold.energy_mJ == heated.energy_mJ
    assert 0.0 < heated.rise_K < 1.0


def test_the_flash_over_a_slow_conductor_is_that_of_a_plane_heated_in_the_rhythm_of_the_slip() -> None:
    depth_mm = 0.015  # To which a cycle's heat gets: little beside the contact's half-width.
    conductivity = 0.05
    slow = solvers.Conductor(conductivity, conductivity / (pi * FREQUENCY_Hz * depth_mm**2))
    even = replace(slow, heat_capacity_J_per_cm3_K=1e12)
    # Under little friction strain takes nothing of the stroke.
    with_flash, without = (worn(solvers.FrictionHeat(one, one), 1e-3, friction=0.01) for one in (slow, even))
    middle = len(with_flash.primary_depth) // 2
    warm, warmed = (float(rises_of(one)[0][middle, 0]) for one in (with_flash, without))
    flash = warm - warmed
    flux = 0.5 * with_flash.primary_energy[middle, 0] / 1e-3 * FREQUENCY_Hz
    # |sin| has the harmonics -1/(4 j² - 1) of its mean, each with the response (Carslaw & Jaeger § 2.6)
    # √(κ/ω)/k that lags by an eighth of its period.
    omega = 2.0 * pi * FREQUENCY_Hz
    exact = sum(
        2.0 / (4.0 * j**2 - 1.0) ** 2 * sqrt(0.5 * slow.diffusivity_mm2_per_s / (2.0 * j * omega))
        for j in range(1, 20)
    )  # fmt: skip
    assert flash == pytest.approx(flux / conductivity * exact, rel=0.06)
    assert warmed > 2.0 * flash


def test_wires_are_as_warm_by_half_a_cycle_and_its_image_as_by_a_whole_one() -> None:
    slow = solvers.Conductor(0.5, 3.6)
    contact = replace(wires(), wear=solvers.WearRates(*RATES, heat=solvers.FrictionHeat(slow, STEEL)))
    state = at_the_end(contact)
    half, whole = (jumped(contact, state, 1.0, symmetry=own).state.wear for own in (None, solvers.Symmetry()))
    for one, other in zip(rises_of(half), rises_of(whole), strict=True):
        assert np.abs(one - other).max() < 0.01 * other.max()
    assert half.rise_K == pytest.approx(whole.rise_K, rel=2e-3)


def test_friction_follows_the_temperature() -> None:
    slope = -2e-3
    contact = line_contact(
        wear=solvers.WearRates(*RATES, heat=solvers.FrictionHeat(THROUGH, THROUGH, friction_per_K=slope))
    )
    state = at_the_end(contact, STROKE_mm)
    for _ in range(4):
        state = jumped(contact, state, 1e-3, stroke_mm=STROKE_mm).state
    after = jumped(contact, state, 1e-3, stroke_mm=STROKE_mm)
    cold = worn(None, 1e-3).energy_mJ / 1e-3
    rise = after.state.wear.rise_K
    # Under less friction the bodies' strain takes less of the stroke.
    assert after.friction_work < (1.0 + 0.8 * slope * rise) * cold
    assert after.friction_work > (1.0 + slope * rise) * cold


def test_warm_debris_takes_the_oxygen_nearer_to_the_edge() -> None:
    oxygen = solvers.OxygenSupply(2e-4, 0.1)
    reaction = solvers.FrictionHeat(THROUGH, THROUGH, oxidation_J_per_mol=5e5)
    plain, warm = worn(None, 100.0, oxygen=oxygen), worn(reaction, 100.0, oxygen=oxygen)
    assert warm.rise_K > 1.0
    shorter = solvers.OxygenSupply(2e-4 / arrhenius(5e5, warm.rise_K), 0.1)
    same = worn(None, 100.0, oxygen=shorter)
    assert warm.primary_volume_mm3 < 0.95 * plain.primary_volume_mm3
    assert warm.primary_volume_mm3 == pytest.approx(same.primary_volume_mm3, rel=0.02)


def test_laws_refuse_bodies_that_cannot_conduct() -> None:
    for wrong in (solvers.Conductor(0.0, 3.6), solvers.Conductor(46.0, 0.0), solvers.Conductor(46.0, 3.6, -1.0)):
        with pytest.raises(solvers.SolverError):
            solvers.FrictionHeat(wrong, STEEL)
