"""Wires flattened before any wear: closed forms of the flats, what is remembered of them, and another model's hooks."""

from dataclasses import replace

import numpy as np
import pytest

from studies.blind.generators.independent.wear_test import snapshots
from studies.blind.generators.independent.world import Specimens, World
from studies.blind.generators.independent.worlds import believed_world
from studies.blind.generators.nominal import Nominal
from tests.diagnosis_cases import diagnosed, nominal, record, states, with_effect
from wirewear.diagnosis.model.flattened_wires import FlattenedWires
from wirewear.diagnosis.model.forward import LoopCourse, simulate
from wirewear.diagnosis.model.setup import Array

CYCLES = np.array([1.0, 100.0, 1000.0, 3000.0, 10_000.0, 100_000.0])


def wires() -> FlattenedWires:
    return replace(states(), stroke_um=60.0).flattened()


def course(flattening_um: float) -> LoopCourse:
    flat = with_effect(nominal(), "plasticity", {"flattening_um": flattening_um})
    return simulate(replace(states(), stroke_um=60.0), flat, CYCLES)


def test_the_flats_have_the_volumes_of_their_closed_forms() -> None:
    deepest, stroke = wires().flattenings[-1], 60.0 / 52.0
    cap, groove = 0.5 * np.pi * deepest**2, 4.0 / 3.0 * stroke * deepest * np.sqrt(2.0 * deepest)
    assert wires().table.volume[-1] == pytest.approx([groove + cap, cap], rel=0.03)


def test_without_flattening_nothing_changes() -> None:
    change = wires().at(np.zeros(2), np.array([0.1, 3.0]))
    for table in (change.slope, change.stiffness, change.approach, change.depth, change.extent, change.volume):
        assert np.all(table == 0.0)


def test_flattened_wires_have_no_hooks_at_first_steep_ends_later_and_none_in_mid_stroke() -> None:
    volumes = np.array([0.0, 0.3, 20.0])
    slope = wires().at(np.full(3, 0.17), volumes).slope
    inner = wires().positions < 0.6
    assert np.all(np.abs(slope[0]) < 0.02)
    assert slope[1, -1] > 0.05
    assert slope[1, -1] > 5.0 * np.abs(slope[1, inner]).max()
    assert 0.0 < slope[2, -1] < 0.2 * slope[1, -1]


def test_a_flattened_contact_is_stiffer_until_the_scar_has_outgrown_it() -> None:
    stiffness = wires().at(np.full(3, 0.17), np.array([0.0, 0.1, 20.0])).stiffness
    assert stiffness[0] > stiffness[1] > 0.1
    assert abs(stiffness[2]) < 0.02


def test_the_moving_scar_is_deeper_the_fixed_one_shallower_and_the_flats_count_in_both() -> None:
    flat, sharp = course(2.0), course(0.0)
    assert flat.scars[0, 1] > sharp.scars[0, 1] + 0.2
    assert flat.scars[1, 1] < sharp.scars[1, 1] - 0.1
    # πR h²/2 of the cap alone, and the groove of 4/3 · 2 · 60 µm · h sqrt(2 R h)/2 beside it.
    gained = flat.scars[:, 0].sum() - sharp.scars[:, 0].sum() - (flat.volume_um3[-1] - sharp.volume_um3[-1])
    assert gained == pytest.approx(np.pi * 225.0 * 4.0 + 80.0 * 2.0 * 30.0, rel=0.1)


def test_wear_lets_flattened_wires_approach_less_so_that_more_of_the_load_stays() -> None:
    gained = course(2.0).normal_force_N[:, 0, 0] - course(0.0).normal_force_N[:, 0, 0]
    assert np.all(np.diff(gained[1:4]) > 0.0)
    assert 5e-4 < gained[-1] < 3e-3


def largest_force_N(world: World) -> Array:
    return np.array([snapshot.loop.tangential_force_N.max() for snapshot in snapshots(world, [1000, 3000])])


def test_the_ends_of_the_hooks_are_those_of_another_model() -> None:
    sharp = believed_world(Nominal(), "dahl", held_on_sensor=False)
    wire = sharp.specimens
    flat = replace(sharp, specimens=Specimens(wire.radius_mm, wire.youngs_modulus_MPa, wire.poissons_ratio, 0.0, 2e-3))
    other = largest_force_N(flat) - largest_force_N(sharp)
    own = [course(h).tangential_force_N[2:4, 0].max(axis=1) for h in (2.0, 0.0)]
    assert own[0] - own[1] == pytest.approx(other, rel=0.3)


@pytest.mark.slow
def test_a_flattening_is_told_from_wear_that_changes() -> None:
    one = diagnosed(record({"plasticity": {"flattening_um": 2.0}}))
    probabilities = one.weighed.probabilities
    assert max(probabilities, key=lambda names: probabilities[names]) == ("plasticity",)
    (cause,) = (cause for cause in one.diagnosis.causes if cause.effect == "plasticity")
    low, high = cause.parameters["flattening_um"].interval95
    assert low < 2.0 < high
