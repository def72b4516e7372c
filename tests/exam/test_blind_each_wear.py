"""Causes of no library in holder, contact and wear: what each does to scars and over cycles is what its name says."""

import numpy as np
import pytest

from geometry.arrays import Array
from studies.blind.causes.changing_air import ChangingAir
from studies.blind.causes.shedding_film import SheddingFilm
from studies.blind.causes.sticking_slide import StickingSlide
from studies.blind.causes.swinging_load import SwingingLoad
from studies.blind.generators.ageing import Film, Growth
from studies.blind.generators.independent.effects import changed
from studies.blind.generators.independent.wear_test import grid_of, snapshots
from tests.exam.blind_causes import STEEL, worn


def test_unequal_wear_moves_volume_from_one_wire_to_the_other() -> None:
    (plain, _), (unequal, _) = worn(), worn("unequal_wear", moving_share=0.8)
    assert unequal.shapes.moving.sum() == pytest.approx(1.6 * plain.shapes.moving.sum(), rel=0.05)
    assert unequal.shapes.fixed.sum() == pytest.approx(0.4 * plain.shapes.fixed.sum(), rel=0.05)


@pytest.mark.parametrize("exponent", [-0.3, 0.3])
def test_wear_that_follows_the_pressure_is_another_in_a_small_scar(exponent: float) -> None:
    other, _ = worn("pressure_dependent_wear", exponent=exponent, pressure_MPa=40.0)
    assert np.sign(exponent) * (other.worn_mm3 / worn()[0].worn_mm3 - 1.0) > 0.1


def test_a_one_sided_holder_shortens_one_side_of_the_loop_alone_and_thicker_wires_wear_shallower() -> None:
    low, high = worn()[0].loop.reach_mm
    for size, sides in ((4.0, (0.0, -4e-3)), (-4.0, (4e-3, 0.0))):
        found = worn("one_sided_holder", um_per_N=size)[0].loop.reach_mm
        assert (found[0] - low, found[1] - high) == pytest.approx(sides, abs=2e-3)
    thick, _ = worn("other_gauge", diameter_factor=1.4)
    assert thick.shapes.fixed.max() < 0.95 * worn()[0].shapes.fixed.max()


def test_values_over_the_cycles_follow_their_laws() -> None:
    # Half gone at its cycle and gone in the end; let go at square multiples of the first cycle.
    assert [Film(0.3, 1e3, 5.0).at(n) for n in (0.0, 1e3, 1e6)] == pytest.approx([0.7, 0.85, 1.0])
    hung = [StickingSlide(0.2, 100.0).at(n) for n in (0.0, 25.0, 99.99, 100.0, 225.0, 399.9, 400.0)]
    assert hung == pytest.approx([1.0, 0.9, 0.8, 1.0, 0.9, 0.8, 1.0], abs=2e-4)
    assert [Growth(3.0, 1e3, 2.0).at(n) for n in (0.0, 500.0, 1e3, 1e4)] == pytest.approx([0.0, 0.75, 3.0, 3.0])
    assert [SheddingFilm(0.2, 100.0).at(n) for n in (0.0, 50.0, 99.0, 100.0, 250.0)] == pytest.approx(
        [1.0, 1.1, 1.198, 1.0, 1.1]
    )
    assert [SwingingLoad(0.1, 400.0, 0.0).at(n) for n in (0.0, 100.0, 200.0, 300.0)] == pytest.approx(
        [1.0, 1.1, 1.0, 0.9]
    )
    steps = ChangingAir(1.2, 0.9, 1.1, 10.0, 100.0, 1e3)
    assert [steps.at(n) for n in (9.0, 10.0, 99.0, 100.0, 1e3)] == [1.0, 1.2, 1.2, 0.9, 1.1]


@pytest.mark.seconds
def test_a_flexure_cracks_late_and_a_pivot_wears_from_the_start() -> None:
    rig = changed(STEEL, "cracking_flexure", {"um_per_N": 4.0, "cycles": 1e4, "power": 3.0}).rig
    assert [rig.loose_mm_per_N(n) for n in (5e3, 1e4)] == pytest.approx([5e-4, 4e-3])
    worn_ = changed(STEEL, "wearing_pivot", {"gap_um": 4.0, "cycles": 1e4}).rig
    assert [worn_.aged(n).play_mm for n in (0.0, 5e3, 1e4)] == pytest.approx([0.0, 2e-3, 4e-3])
    # The play of the end is what a constant play of that width is.
    assert worn("wearing_pivot", gap_um=4.0, cycles=2000.0)[1].tangential_force_N == pytest.approx(
        worn("free_play", gap_um=4.0)[1].tangential_force_N, abs=0.05
    )


def test_a_joint_opens_under_both_signs_of_large_forces_alone() -> None:
    force = np.linspace(-1.2, 1.2, 25)
    (joint,) = changed(STEEL, "opening_joint", {"preload_N": 0.6, "um_per_N": 5.0}).rig.joints
    moved = joint.moved_mm(force, -1.2, 1)
    assert (moved[np.abs(force) < 0.6] == 0.0).all()
    assert moved[[0, -1]] == pytest.approx([-3e-3, 3e-3])
    assert joint.moved_mm(force[::-1], 1.2, -1)[::-1] == pytest.approx(moved)


def test_microslip_in_a_joint_closes_its_loop_and_takes_work() -> None:
    force = np.linspace(-1.2, 1.2, 25)
    (joint,) = changed(STEEL, "microslipping_joint", {"um_per_N2": 2.0}).rig.joints
    there, back = joint.moved_mm(force, -1.2, 1), joint.moved_mm(force[::-1], 1.2, -1)[::-1]
    assert there[[0, -1]] == pytest.approx([-2e-3 * 1.2**2, 2e-3 * 1.2**2])
    assert back[[0, -1]] == pytest.approx(there[[0, -1]])
    assert (back - there)[1:-1].min() > 0.0
    (plain, _), (slipping, _) = worn(), worn("microslipping_joint", um_per_N2=2.0)
    largest = float(slipping.loop.tangential_force_N.max())
    assert plain.loop.reach_mm[1] - slipping.loop.reach_mm[1] == pytest.approx(2e-3 * largest**2, rel=0.05)


@pytest.mark.seconds
def test_wear_hardly_begins_under_a_coat_and_in_a_hard_skin() -> None:
    plain = worn()[0].worn_mm3
    assert worn("incubated_wear", share=0.95, cycle=1e5, abruptness=6.0)[0].worn_mm3 == pytest.approx(
        0.05 * plain, rel=0.1
    )
    for factor in (0.3, 2.0):
        early = worn("hard_skin", 100, factor=factor, depth_um=50.0)[0].worn_mm3 / worn("", 100)[0].worn_mm3
        assert early == pytest.approx(factor, rel=0.1)
    # Once the scar is deeper than the skin, it wears as ever.
    assert worn("hard_skin", factor=0.3, depth_um=0.02)[0].worn_mm3 == pytest.approx(plain, rel=0.05)


def test_a_used_wire_brings_its_old_scar_along_and_the_other_wire_none() -> None:
    world = changed(STEEL, "used_wire", {"depth_um": 3.0, "aside_um": 20.0})
    fresh, *_ = snapshots(world, [0], 16)
    grid = grid_of(world, 16)
    place = np.unravel_index(int(fresh.shapes.fixed.argmax()), fresh.shapes.fixed.shape)
    assert fresh.shapes.fixed.max() == pytest.approx(3e-3, rel=0.05)
    assert grid.y_mm[place[0]] == pytest.approx(0.02, abs=grid.spacing_mm)
    assert fresh.shapes.moving.max() == 0.0


def test_a_flat_section_makes_a_wide_scar_and_one_on_edge_a_narrow_one() -> None:
    def width(**sizes: float) -> float:
        depth = (worn("rolled_wire", **sizes) if sizes else worn())[0].shapes.fixed
        return float((depth.max(axis=0) > 0.05 * depth.max()).sum())

    assert width(crown_factor=0.5) < width() < width(crown_factor=2.0)


def test_a_lopsided_track_is_deeper_at_one_end_and_wears_as_much() -> None:
    (plain, _), (up, _), (down, _) = worn(), worn("lopsided_wear", slant=0.5), worn("lopsided_wear", slant=-0.5)
    assert up.shapes.moving == pytest.approx(down.shapes.moving[:, ::-1], abs=1e-9)
    assert up.worn_mm3 == pytest.approx(plain.worn_mm3, rel=0.05)
    along = grid_of(STEEL, 10).moving_x_mm
    middle = [float(shot.shapes.moving.sum(axis=0) @ along / shot.shapes.moving.sum()) for shot in (plain, up)]
    assert middle[0] == pytest.approx(0.0, abs=1e-9)
    assert abs(middle[1]) > 5e-3


def test_a_flake_leaves_a_pit_in_one_wire_at_its_cycle() -> None:
    sizes = {"depth_um": 5.0, "radius_um": 30.0, "x_um": 10.0, "y_um": -20.0, "cycle": 1000.0}
    world = changed(STEEL, "spalled_flake", sizes)
    before, after = snapshots(world, [999, 1000], 16)
    lost = after.shapes.fixed - before.shapes.fixed
    grid = grid_of(world, 16)
    row, column = np.unravel_index(int(lost.argmax()), lost.shape)
    assert lost.max() == pytest.approx(5e-3, rel=0.1)
    assert (grid.x_mm[column], grid.y_mm[row]) == pytest.approx((0.01, -0.02), abs=grid.spacing_mm)
    assert np.abs(after.shapes.moving - before.shapes.moving).max() < 1e-4


def test_a_wire_put_back_turned_has_its_scar_aside_and_is_worn_in_again() -> None:
    world = changed(STEEL, "remounted_wire", {"aside_um": 20.0, "cycle": 1000.0})
    before, after, late = snapshots(world, [999, 1000, 3000], 16)
    grid = grid_of(world, 16)

    def middle_mm(fixed: Array) -> float:
        return float(fixed.sum(axis=0) @ grid.x_mm / fixed.sum())

    assert middle_mm(before.shapes.fixed) == pytest.approx(0.0, abs=1e-3)
    assert middle_mm(after.shapes.fixed) == pytest.approx(0.02, abs=2e-3)
    assert middle_mm(late.shapes.fixed) < middle_mm(after.shapes.fixed)
    # The contact moves to one side of the old scar, whose slope the force shows as a mean.
    means = [abs(float(shot.loop.tangential_force_N.mean())) for shot in (before, after)]
    assert means[0] < 1e-3
    assert means[1] > 0.01


def test_a_groove_lies_along_the_fixed_wire_and_leaves_the_other_whole() -> None:
    world = changed(STEEL, "grooved_wire", {"depth_um": 2.0, "half_width_um": 40.0, "aside_um": 15.0})
    fresh, *_ = snapshots(world, [0], 16)
    grid = grid_of(world, 16)
    assert fresh.shapes.moving.max() == 0.0
    assert (fresh.shapes.fixed == fresh.shapes.fixed[0]).all()
    assert grid.x_mm[int(fresh.shapes.fixed[0].argmax())] == pytest.approx(0.015, abs=grid.spacing_mm)
    assert fresh.shapes.fixed.max() == pytest.approx(2e-3, rel=0.05)
    assert (fresh.shapes.fixed[0] > 0.0).sum() * grid.spacing_mm == pytest.approx(0.08, abs=1.1 * grid.spacing_mm)
