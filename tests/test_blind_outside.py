"""Causes of no library in two halves: each does what its name says, and the halves share none."""

from functools import cache

import numpy as np
import pytest

from studies.blind.generators.generator import LIBRARY_EFFECTS
from studies.blind.generators.independent.effects import changed
from studies.blind.generators.independent.loop import TrueLoop
from studies.blind.generators.independent.reserved import RESERVED
from studies.blind.generators.independent.sensing import Reading, read
from studies.blind.generators.independent.unknown_causes import DEVELOPMENT, FIRST, OUTSIDE, SEALED, UNSEEN
from studies.blind.generators.independent.wear_test import snapshots
from studies.blind.generators.independent.withheld import WITHHELD
from studies.blind.generators.independent.world import World
from studies.blind.generators.independent.worlds import believed_world
from studies.blind.generators.nominal import Nominal
from studies.blind.scoring.answers import OUTSIDE as UNKNOWN
from studies.blind.scoring.judging import Truth, judged
from tests.blind_batches import answer

STEEL = believed_world(Nominal(), "dahl", held_on_sensor=False)
PHASE = 2.0 * np.pi * np.arange(1440) / 1440

#: A loop in closed form: a sine of 60 µm, forces of ±1.2 N that turn within some degrees of each reversal.
LOOP = TrueLoop(0.06 * np.sin(PHASE), 1.2 * np.tanh(8.0 * np.cos(PHASE - 0.3)), np.full(1440, 2.0), (-0.055, 0.055))


def seen(effect: str, cycle: float = 1.0, **parameters: float) -> Reading:
    return read(changed(STEEL, effect, parameters), LOOP, cycle)


@cache
def loop_of(effect: str = "", **parameters: float) -> Reading:
    """Readings of the tenth cycle, on a coarse grid."""
    world: World = changed(STEEL, effect, parameters) if effect else STEEL
    [snapshot] = snapshots(world, [10], 10)
    return read(world, snapshot.loop, 10)


def area_mJ(reading: Reading) -> float:
    x, q = reading.displacement_mm, reading.tangential_force_N
    return abs(float(np.sum(0.5 * (q + np.roll(q, -1)) * (np.roll(x, -1) - x))))


def test_there_are_sixteen_kinds_and_more_in_two_halves_over_all_seams() -> None:
    assert len(set(DEVELOPMENT) | set(SEALED)) >= 16
    assert set(DEVELOPMENT) & set(SEALED) == set()
    assert set(OUTSIDE) == set(FIRST) | set(DEVELOPMENT) | set(SEALED) | set(UNSEEN) | set(WITHHELD) | set(RESERVED)
    assert not set(UNSEEN) & (set(DEVELOPMENT) | set(SEALED))
    assert set(FIRST) <= set(DEVELOPMENT) | set(SEALED)
    assert not set(OUTSIDE) & set(LIBRARY_EFFECTS)


def test_an_asymmetric_cell_stretches_one_sign_of_the_force() -> None:
    force = seen("asymmetric_force_cell", asymmetry=0.1).tangential_force_N
    assert force.max() == pytest.approx(1.1 * LOOP.tangential_force_N.max())
    assert force.min() == pytest.approx(0.9 * LOOP.tangential_force_N.min())


def test_a_cell_with_hysteresis_loses_its_play_from_end_to_end() -> None:
    force = seen("force_cell_hysteresis", play_N=0.2).tangential_force_N
    assert np.ptp(force) == pytest.approx(np.ptp(LOOP.tangential_force_N) - 0.2, rel=1e-6)


def test_a_creeping_zero_moves_the_whole_loop_over_the_test() -> None:
    late = seen("creeping_force_zero", cycle=1e6, zero_N=0.1, cycles=1000.0).tangential_force_N
    early = seen("creeping_force_zero", cycle=1.0, zero_N=0.1, cycles=1000.0).tangential_force_N
    assert late - LOOP.tangential_force_N == pytest.approx(0.1, abs=1e-6)
    assert np.abs(early - LOOP.tangential_force_N).max() < 1e-3


def test_a_bent_sensor_is_right_at_both_ends_and_in_the_middle() -> None:
    moved = 1e3 * (seen("bent_displacement_sensor", bend=0.1).displacement_mm - LOOP.displacement_mm)
    for place in (0.0, 0.06, -0.06):
        assert moved[np.argmin(np.abs(LOOP.displacement_mm - place))] == pytest.approx(0.0, abs=0.02)
    assert np.abs(moved).max() == pytest.approx(0.1 * 60.0 * 2.0 / 3.0**1.5, rel=0.01)


def test_backlash_parts_the_branches_by_its_width() -> None:
    read_mm = seen("displacement_backlash", play_um=4.0).displacement_mm
    rising = np.cos(PHASE) > 0.5
    falling = np.cos(PHASE) < -0.5
    assert 1e3 * (LOOP.displacement_mm - read_mm)[rising] == pytest.approx(2.0)
    assert 1e3 * (read_mm - LOOP.displacement_mm)[falling] == pytest.approx(2.0)


def test_a_parallel_spring_adds_a_force_that_follows_the_place_and_no_area() -> None:
    sprung = seen("parallel_spring", stiffness_N_per_mm=2.0)
    assert sprung.tangential_force_N - LOOP.tangential_force_N == pytest.approx(2.0 * LOOP.displacement_mm)
    plain = Reading(LOOP.displacement_mm, LOOP.tangential_force_N, LOOP.normal_force_N)
    assert area_mJ(sprung) == pytest.approx(area_mJ(plain), rel=1e-9)


def test_a_stiffening_holder_costs_area_as_a_compliance_does() -> None:
    assert area_mJ(loop_of("stiffening_holder", hardening_um_per_N3=4.0)) < 0.99 * area_mJ(loop_of())


def test_a_holder_comes_loose_by_the_end_of_the_test_alone() -> None:
    rig = changed(STEEL, "loosening_holder", {"loosening_um_per_N": 3.0, "cycles": 1e4}).rig
    assert rig.loose_mm_per_N(10.0) < 1e-5
    assert rig.loose_mm_per_N(1e5) == pytest.approx(3e-3, rel=1e-3)


def test_friction_and_load_that_slant_raise_one_end_of_the_stroke() -> None:
    for effect, parameters in (("slanted_friction", {"rise": 0.2}), ("slanted_load", {"load_rise": 0.2})):
        slanted, plain = loop_of(effect, **parameters), loop_of()
        # Late on either branch, where the contact slides for certain.
        width = np.abs(slanted.tangential_force_N) - np.abs(plain.tangential_force_N)
        right, left = plain.displacement_mm > 0.035, plain.displacement_mm < -0.035
        slides = np.abs(plain.tangential_force_N) > 1.1
        assert width[right & slides].mean() > 0.08, effect
        assert width[left & slides].mean() < -0.08, effect


def test_friction_ripples_along_the_stroke_at_its_length() -> None:
    rippled, plain = loop_of("rippled_friction", share=0.05, length_um=10.0), loop_of()
    slides = (np.abs(plain.displacement_mm) < 0.03) & (plain.tangential_force_N > 1.1)
    place = 1e3 * plain.displacement_mm[slides]
    rest = rippled.tangential_force_N[slides] - plain.tangential_force_N[slides]
    waves = [abs(np.mean(rest * np.exp(2j * np.pi * place / length))) for length in (7.0, 10.0, 14.0)]
    assert np.argmax(waves) == 1
    assert 2.0 * waves[1] == pytest.approx(0.05 * 1.24, rel=0.3)


def test_friction_breathes_and_wear_is_severe_for_a_while() -> None:
    friction = changed(STEEL, "breathing_friction", {"share": 0.1, "folds": 2.0}).friction
    values = [friction.at(cycle) for cycle in np.geomspace(1.0, 1e5, 200)]
    assert max(values) == pytest.approx(1.1 * 0.62, rel=1e-2)
    assert min(values) == pytest.approx(0.9 * 0.62, rel=1e-2)
    wear = changed(STEEL, "severe_wear", {"factor": 4.0, "cycle": 1e4, "recovery_cycles": 5e3}).wear
    assert [wear.factor_at(cycle) for cycle in (9999.0, 1e4)] == [1.0, 4.0]
    assert wear.factor_at(1e5) == pytest.approx(1.0, abs=1e-6)


def test_an_effect_that_another_one_contains_cannot_be_unexplained() -> None:
    """A wear rate that is left out of the library is a course of the wear rate that stays."""
    truth = Truth("case_1", "left_out", "easy", ("wear_rate_offset",), {"wear_rate_offset": {"factor": 1.5}}, 9.0)
    assert not truth.is_open
    assert judged(truth, answer("explained", {"wear_rate_evolution": 0.9})).first_right
    assert not judged(truth, answer("unexplained", {UNKNOWN: 0.9})).first_right
    open_ = Truth("case_2", "left_out", "easy", ("free_play",), {"free_play": {"gap_um": 3.0}}, 9.0)
    assert open_.is_open
    assert judged(open_, answer("unexplained", {UNKNOWN: 0.9})).first_right
