"""Causes of the withheld set: at all seams, the same again, without a trace, in both tiers alike, and how large."""

from pathlib import Path

import numpy as np
import pytest

from studies.blind.generators.ageing import Growth, Shedding, Steps, Swing
from studies.blind.generators.generator import LIBRARY_EFFECTS
from studies.blind.generators.independent.effects import changed
from studies.blind.generators.independent.unknown_causes import DEVELOPMENT, FIRST, SEALED, UNSEEN
from studies.blind.generators.independent.wear_test import grid_of, snapshots
from studies.blind.generators.independent.withheld import WITHHELD
from studies.blind.scoring.seams import OUTSIDE_SEAMS
from tests.test_blind_unseen import LOOP, STEEL, TURN, area_mJ, require_read_alike
from tests.withheld_causes import (
    AT_SEAMS,
    NOTHING,
    ONE_WAY,
    READ,
    drawn,
    gaps_in_scatters,
    require_alike_at_seams,
    require_traceless,
    require_untouched,
    seen,
    shown,
    worn,
)
from wirewear.effects import Seam


@pytest.mark.parametrize("effect", READ)
def test_a_loop_stays_odd_over_half_a_cycle_but_where_one_end_or_sign_differs(effect: str) -> None:
    parameters = drawn(effect)
    found = seen(effect, LOOP, parameters.get("cycle_1", 1e5), **parameters)
    force = found.tangential_force_N
    rest = np.abs(force + np.roll(force, force.size // 2)).max() / np.abs(force).max()
    assert (rest > 1e-3) if effect in ONE_WAY else (rest < 1e-9)
    assert found.displacement_um == pytest.approx(-np.roll(found.displacement_um, 720), abs=1e-9)


@pytest.mark.parametrize("effect", [effect for effect in READ if effect not in ("rattling_weight", "averaging_logger")])
def test_what_is_no_load_leaves_the_normal_force_and_the_displacement(effect: str) -> None:
    found = seen(effect, **drawn(effect))
    assert (found.normal_force_N == LOOP.normal_force_N).all()
    assert (found.displacement_um == LOOP.displacement_um).all()


def test_an_overloaded_cell_reads_less_and_beside_zero_from_its_cycle_on() -> None:
    sizes = {"loss": 0.1, "zero_N": -0.05, "cycle": 1e3}
    assert seen("overloaded_cell", LOOP, 999.0, **sizes) is LOOP
    late = seen("overloaded_cell", LOOP, 1e3, **sizes).tangential_force_N
    assert late == pytest.approx(0.9 * LOOP.tangential_force_N - 0.05)


def test_a_loose_plug_moves_the_zero_in_two_spells() -> None:
    moments = {f"cycle_{i}": 10.0**i for i in (1, 2, 3, 4)}
    moved = {
        cycle: float(np.mean(seen("loose_plug", LOOP, cycle, zero_N=0.2, **moments).tangential_force_N))
        for cycle in (9.0, 10.0, 99.0, 100.0, 999.0, 1e3, 9999.0, 1e4)
    }
    assert list(moved.values()) == pytest.approx([0.0, 0.2, 0.2, 0.0, 0.0, 0.2, 0.2, 0.0], abs=1e-9)


def test_an_amplifier_follows_no_faster_than_its_slew_rate_and_reaches_the_plateaus() -> None:
    slow = seen("slew_limited_amplifier", N_per_s=15.0).tangential_force_N
    steps = np.diff(slow, append=slow[0]) / LOOP.time_s[1]
    assert np.abs(steps).max() == pytest.approx(15.0)
    assert np.abs(np.gradient(LOOP.tangential_force_N, LOOP.time_s)).max() > 60.0
    assert slow.max() == pytest.approx(LOOP.tangential_force_N.max(), rel=0.005)


def test_nothing_comes_out_of_an_amplifier_within_its_band() -> None:
    force = seen("crossover_distortion", band_N=0.3).tangential_force_N
    assert (force[np.abs(LOOP.tangential_force_N) < 0.3] == 0.0).all()
    plateau = LOOP.tangential_force_N > 1.19
    assert force[plateau] == pytest.approx(LOOP.tangential_force_N[plateau] - 0.3)


def test_an_average_over_a_window_rounds_all_channels_and_delays_none() -> None:
    averaged = seen("averaging_logger", time_s=1.0 / 30.0)
    # A tenth of a cycle: the mean of 144 samples.
    window = np.ones(145)
    window[[0, -1]] = 0.5
    for name in ("displacement_um", "tangential_force_N"):
        true = getattr(LOOP, name)
        wrapped = np.concatenate([true[-72:], true, true[:72]])
        assert getattr(averaged, name) == pytest.approx(np.convolve(wrapped, window / 144.0, "valid"), abs=2e-3), name


def test_a_hard_spot_stands_at_one_place_of_the_stroke_both_ways() -> None:
    ratio = seen("hard_spot", rise=0.3, place=0.4, width=0.1).tangential_force_N / LOOP.tangential_force_N
    place = LOOP.displacement_um / 60.0
    for way in (np.cos(TURN) > 0.2, np.cos(TURN) < -0.2):
        assert place[way][ratio[way].argmax()] == pytest.approx(0.4, abs=0.01)
        assert ratio[way].max() == pytest.approx(1.3, abs=1e-3)
    assert ratio[place < 0.0] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_ridge_pushes_back_at_one_end_alone_grows_and_takes_no_work(side: float) -> None:
    sizes = {"force_N": 0.2 * side, "begins": 0.5, "cycles": 1e3}
    push = seen("debris_ridge", LOOP, 1e3, **sizes).tangential_force_N - LOOP.tangential_force_N
    place = side * LOOP.displacement_um / 60.0
    assert side * push[place.argmax()] == pytest.approx(0.2)
    assert push[place < 0.5] == pytest.approx(0.0, abs=1e-12)
    early = seen("debris_ridge", LOOP, 250.0, **sizes)
    assert early.tangential_force_N - LOOP.tangential_force_N == pytest.approx(0.25 * push)
    assert area_mJ(early) == pytest.approx(area_mJ(LOOP), rel=1e-6)


def test_grease_drags_with_the_speed_and_is_squeezed_out() -> None:
    drag = seen("thinning_grease", LOOP, 0.0, force_N=0.2, cycles=1e3).tangential_force_N - LOOP.tangential_force_N
    assert drag == pytest.approx(0.2 * np.cos(TURN), abs=1e-4)
    late = seen("thinning_grease", LOOP, 3e3, force_N=0.2, cycles=1e3).tangential_force_N - LOOP.tangential_force_N
    assert late == pytest.approx(np.exp(-3.0) * drag, abs=1e-9)


def test_a_weight_rattles_after_each_reversal_until_it_has_died_away() -> None:
    factor = seen("rattling_weight", share=0.3, frequency_Hz=18.0, time_s=0.03).normal_force_N / 2.0
    assert factor[[360, 1080]] == pytest.approx(1.0)
    assert factor == pytest.approx(np.roll(factor, 720))
    # A quarter of its period after the reversal at 90°, and just before the next one.
    assert factor[420] == pytest.approx(1.0 + 0.3 * np.exp(-1.0 / 72.0 / 0.03), rel=1e-3)
    assert np.abs(factor[1000:1080] - 1.0).max() < 0.005


def test_values_over_the_cycles_follow_their_laws() -> None:
    assert [Growth(3.0, 1e3, 2.0).at(n) for n in (0.0, 500.0, 1e3, 1e4)] == pytest.approx([0.0, 0.75, 3.0, 3.0])
    assert [Shedding(0.2, 100.0).at(n) for n in (0.0, 50.0, 99.0, 100.0, 250.0)] == pytest.approx(
        [1.0, 1.1, 1.198, 1.0, 1.1]
    )
    assert [Swing(0.1, 400.0, 0.0).at(n) for n in (0.0, 100.0, 200.0, 300.0)] == pytest.approx([1.0, 1.1, 1.0, 0.9])
    steps = Steps(((10.0, 1.2), (100.0, 0.9), (1e3, 1.1)))
    assert [steps.at(n) for n in (9.0, 10.0, 99.0, 100.0, 1e3)] == [1.0, 1.2, 1.2, 0.9, 1.1]


@pytest.mark.seconds
def test_a_flexure_cracks_late_and_a_pivot_wears_from_the_start() -> None:
    rig = changed(STEEL, "cracking_flexure", {"um_per_N": 4.0, "cycles": 1e4, "power": 3.0}).rig
    assert [rig.loose_mm_per_N(n) for n in (5e3, 1e4)] == pytest.approx([5e-4, 4e-3])
    worn_ = changed(STEEL, "wearing_pivot", {"gap_um": 4.0, "cycles": 1e4}).rig
    assert [worn_.aged(n).play_mm for n in (0.0, 5e3, 1e4)] == pytest.approx([0.0, 2e-3, 4e-3])
    # The play of the end is what a constant play of that width is.
    assert shown("wearing_pivot", gap_um=4.0, cycles=2000.0).tangential_force_N == pytest.approx(
        shown("free_play", gap_um=4.0).tangential_force_N, abs=0.05
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


def test_there_are_twelve_kinds_and_more_at_all_seams_that_no_other_set_has() -> None:
    seams = [OUTSIDE_SEAMS[effect] for effect in WITHHELD]
    assert len(WITHHELD) >= 12
    assert all(seams.count(seam) >= 2 for seam in ("sensor", "holder", "contact"))
    assert set(seams) == set(Seam)
    assert set(NOTHING) == set(WITHHELD)
    assert not set(WITHHELD) & {*FIRST, *DEVELOPMENT, *SEALED, *UNSEEN, *LIBRARY_EFFECTS}


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize("effect", ["crossover_distortion", "loose_plug", "opening_joint", "used_wire"])
def test_records_are_the_same_again_and_their_files_of_one_size_without_the_cause(effect: str, tmp_path: Path) -> None:
    require_traceless(effect, WITHHELD, tmp_path)


@pytest.mark.parametrize("effect", WITHHELD)
def test_a_cause_of_no_size_leaves_the_test_as_it_is(effect: str) -> None:
    require_untouched(effect, NOTHING[effect])


@pytest.mark.parametrize("effect", READ)
def test_both_tiers_read_the_same_of_the_same_loop(effect: str) -> None:
    require_read_alike(effect, drawn(effect))


@pytest.mark.parametrize("effect", AT_SEAMS)
def test_both_tiers_have_the_same_holder_friction_load_and_wear_at_every_cycle(effect: str) -> None:
    require_alike_at_seams(effect)


@pytest.mark.slow
def test_sizes_of_gaps_lie_about_two_to_twenty_scatters() -> None:
    for effect in WITHHELD:
        size = gaps_in_scatters(effect)
        assert size["hard"] < size["easy"], effect
        assert 0.5 < size["hard"] < 15.0, effect
        assert 4.0 < size["easy"] < 50.0, effect
