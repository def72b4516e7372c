"""Causes of no library, each by itself: what it does to a loop, to a scar or over the cycles is what its name says."""

from dataclasses import replace

import numpy as np
import pytest

from geometry.arrays import Array
from studies.blind.generators.ageing import Film, Growth, Hanging, Shedding, Steps, Swing
from studies.blind.generators.independent.effects import changed
from studies.blind.generators.independent.reserved import RESERVED
from studies.blind.generators.independent.wear_test import grid_of, snapshots
from studies.blind.generators.independent.withheld import WITHHELD
from studies.blind.generators.instruments import Signals
from studies.blind.generators.strokes import since_reversal
from tests.blind_causes import BACK, BLOCK, FORTH, LOOP, READ, STEEL, TURN, area_mJ, drawn, seen, worn

LOADS = {"hunting_servo", "touching_stop"}  #: What is load, which both forces follow.
#: A block whose spring turns within 0.6 µm.
PASSED, DIRECTION = since_reversal(LOOP)
STIFF = replace(LOOP, tangential_force_N=np.asarray(1.2 * DIRECTION * np.clip(PASSED / 0.3 - 1.0, -1.0, 1.0)))


def test_a_leaking_charge_holds_no_force() -> None:
    lasting = replace(LOOP, tangential_force_N=LOOP.tangential_force_N + 0.5)
    assert seen("leaking_charge", lasting, time_s=0.5).tangential_force_N.mean() == pytest.approx(0.0, abs=1e-9)
    square = replace(LOOP, tangential_force_N=np.asarray(np.sign(np.cos(TURN + 1e-3))))
    force = seen("leaking_charge", square, time_s=0.5).tangential_force_N
    # From 90° to 270° a plateau decays exponentially; the ends ring on a grid of samples.
    assert force[1040] / force[400] == pytest.approx(np.exp(-640 / 1440 / 3.0 / 0.5), rel=0.01)


def test_a_heavy_holder_rings_at_its_own_frequency() -> None:
    rung = seen("ringing_force_cell", natural_frequency_Hz=45.0, damping=0.05).tangential_force_N
    true = np.abs(np.fft.rfft(LOOP.tangential_force_N))
    gained = np.abs(np.fft.rfft(rung))[[1, 15]] / true[[1, 15]]
    assert gained == pytest.approx([1.0 / (1.0 - 1.0 / 225.0), 10.0], rel=1e-3)


def test_hysteresis_of_the_displacement_is_widest_in_mid_stroke_and_nothing_at_the_ends() -> None:
    found = seen("hysteretic_displacement", share=0.1).displacement_um
    lag = LOOP.displacement_um - found
    assert lag[[0, 720]] == pytest.approx([6.0, -6.0])
    assert lag[[360, 1080]] == pytest.approx(0.0, abs=1e-9)


def test_a_creeping_joint_takes_work_and_an_elastic_one_none() -> None:
    plain = area_mJ(LOOP)
    elastic = seen("creeping_joint", um_per_N=3.0, time_s=1e-9)
    assert elastic.displacement_um == pytest.approx(LOOP.displacement_um + 3.0 * LOOP.tangential_force_N, abs=1e-4)
    assert area_mJ(elastic) == pytest.approx(plain, rel=1e-6)
    assert area_mJ(seen("creeping_joint", um_per_N=3.0, time_s=0.05)) > 1.01 * plain


def test_a_guide_drags_with_its_force_and_takes_its_work() -> None:
    dragged = seen("dragging_guide", force_N=0.1, over_um=4.0)
    # A spring that turns within 4 µm from end to end, then sliding: 4 F (A − d/2).
    assert area_mJ(dragged) - area_mJ(LOOP) == pytest.approx(4e-3 * 0.1 * (60.0 - 2.0), rel=1e-3)
    assert (dragged.normal_force_N == LOOP.normal_force_N).all()


def test_a_lever_that_sticks_loads_one_way_more_than_the_other_and_takes_no_work() -> None:
    stuck = seen("sticking_lever", share=0.1, over_um=6.0)
    assert stuck.normal_force_N[[0, 720]] == pytest.approx([2.2, 1.8])
    assert area_mJ(stuck) == pytest.approx(area_mJ(LOOP), rel=1e-6)


def test_weights_bounce_twice_a_cycle() -> None:
    load = np.abs(np.fft.rfft(seen("bouncing_weight", share=0.2, phase_rad=1.0).normal_force_N)) / 720
    assert load[1:5] == pytest.approx([0.0, 0.4, 0.0, 0.0], abs=1e-9)


def test_a_supply_that_fades_takes_both_forces_and_leaves_their_ratio() -> None:
    late = seen("fading_supply", LOOP, 1e6, change=-0.1, cycles=1e3)
    assert late.tangential_force_N == pytest.approx(0.9 * LOOP.tangential_force_N)
    assert late.normal_force_N == pytest.approx(0.9 * LOOP.normal_force_N)


def test_hooks_rise_towards_the_end_of_either_stroke_and_take_nearly_no_work() -> None:
    hooked = seen("hooked_friction", BLOCK, rise=0.2)
    gained = np.abs(hooked.tangential_force_N) - 1.2
    assert gained[FORTH] == pytest.approx(0.24 * np.sin(TURN[FORTH]) ** 3)
    assert gained[BACK] == pytest.approx(-0.24 * np.sin(TURN[BACK]) ** 3)
    assert area_mJ(hooked) == pytest.approx(area_mJ(BLOCK), rel=2e-3)


def test_a_film_is_half_gone_at_its_cycle_and_gone_in_the_end() -> None:
    film = Film(0.3, 1e3, 5.0)
    assert [film.at(cycle) for cycle in (0.0, 1e3, 1e6)] == pytest.approx([0.7, 0.85, 1.0])


def test_unequal_wear_moves_volume_from_one_wire_to_the_other() -> None:
    (plain, _), (unequal, _) = worn(), worn("unequal_wear", moving_share=0.8)
    assert unequal.shapes.moving.sum() == pytest.approx(1.6 * plain.shapes.moving.sum(), rel=0.05)
    assert unequal.shapes.fixed.sum() == pytest.approx(0.4 * plain.shapes.fixed.sum(), rel=0.05)


@pytest.mark.parametrize("exponent", [-0.3, 0.3])
def test_wear_that_follows_the_pressure_is_another_in_a_small_scar(exponent: float) -> None:
    other, _ = worn("pressure_dependent_wear", exponent=exponent, pressure_MPa=40.0)
    assert np.sign(exponent) * (other.worn_mm3 / worn()[0].worn_mm3 - 1.0) > 0.1


def test_a_one_sided_holder_shortens_one_side_of_the_loop_alone() -> None:
    low, high = worn()[0].loop.reach_mm
    for size, sides in ((4.0, (0.0, -4e-3)), (-4.0, (4e-3, 0.0))):
        found = worn("one_sided_holder", um_per_N=size)[0].loop.reach_mm
        assert (found[0] - low, found[1] - high) == pytest.approx(sides, abs=2e-3)


def test_thicker_wires_wear_shallower() -> None:
    thick, _ = worn("other_gauge", diameter_factor=1.4)
    assert thick.shapes.fixed.max() < 0.95 * worn()[0].shapes.fixed.max()


@pytest.mark.parametrize("effect", sorted({*READ} & {*WITHHELD} - {"rattling_weight", "averaging_logger"}))
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


def factor_on_force(found: Signals, of: Signals = BLOCK) -> Array:
    return np.asarray(found.tangential_force_N / of.tangential_force_N)


@pytest.mark.parametrize("effect", sorted({*READ} & {*RESERVED}))
def test_the_normal_force_is_another_under_other_loads_alone(effect: str) -> None:
    found = seen(effect, **drawn(effect))
    assert (np.abs(found.normal_force_N - LOOP.normal_force_N).max() > 1e-3) == (effect in LOADS)
    if effect in LOADS:
        ratio = found.normal_force_N / LOOP.normal_force_N
        assert found.tangential_force_N == pytest.approx(LOOP.tangential_force_N * ratio)


def test_an_encoder_errs_alike_a_line_of_its_scale_further() -> None:
    place = np.linspace(-60.0, 60.0, 1201)
    scanned = replace(BLOCK, displacement_um=place)
    error = seen("cyclic_encoder", scanned, error_um=2.0, pitch_um=20.0, phase_rad=0.5).displacement_um - place
    assert error[200:] == pytest.approx(error[:-200], abs=1e-9)
    assert np.ptp(error) == pytest.approx(4.0, rel=1e-3)
    assert error[600] == pytest.approx(0.0, abs=1e-9)


def test_a_coarse_converter_reads_whole_steps_and_errs_by_half_of_one() -> None:
    force = seen("coarse_converter", step_N=0.5).tangential_force_N
    assert set(np.unique(force).tolist()) == {-1.0, -0.5, 0.0, 0.5, 1.0}
    assert np.abs(force - LOOP.tangential_force_N).max() <= 0.25


@pytest.mark.parametrize("limit", [50.0, -50.0])
def test_a_laser_reads_no_further_than_its_range_at_one_end(limit: float) -> None:
    read = seen("laser_out_of_range", limit_um=limit).displacement_um
    true = LOOP.displacement_um
    inside = np.sign(limit) * true <= 50.0
    assert (read[inside] == true[inside]).all()
    assert (read[~inside] == limit).all()


def test_a_logger_halts_from_the_upper_reversal_on_and_catches_up_at_once() -> None:
    force = seen("halting_logger", time_s=1.0 / 30.0).tangential_force_N
    # A tenth of a cycle from 90° on.
    assert (force[360:504] == LOOP.tangential_force_N[360]).all()
    assert (np.delete(force, slice(360, 504)) == np.delete(LOOP.tangential_force_N, slice(360, 504))).all()


def test_wires_stick_and_slip_along_both_strokes_and_end_them_about_to_slip() -> None:
    factor = factor_on_force(seen("stick_slip", BLOCK, share=0.3, per_stroke=5.0))
    drops = np.flatnonzero(np.diff(factor) < -0.2)
    assert drops.size == 8
    assert factor.min() == pytest.approx(0.7, abs=0.01)
    assert factor[[359, 1079]] == pytest.approx(1.0, abs=0.01)
    assert factor[drops[0] + 1 :][:1] == pytest.approx(factor[drops[4] + 1 :][:1], abs=0.02)


def test_debris_rolls_after_each_reversal_until_it_jams_and_changes_nothing_at_once() -> None:
    found = seen("rolling_debris", loss=0.2, over=0.4)
    factor = factor_on_force(found, LOOP)
    place = LOOP.displacement_um / 60.0
    # Forty percent of a stroke end at −0.2 on the way there and at 0.2 on the way back.
    assert factor[FORTH & (place > 0.0)] == pytest.approx(1.0, abs=0.04)
    assert factor[FORTH & (place > -0.7) & (place < -0.4)] == pytest.approx(0.8, abs=0.02)
    assert factor[BACK & (place < 0.7) & (place > 0.4)] == pytest.approx(0.8, abs=0.02)
    steps = np.abs(np.diff(found.tangential_force_N)).max()
    assert steps < 1.1 * np.abs(np.diff(LOOP.tangential_force_N)).max()


@pytest.mark.parametrize("end", [1.0, -1.0])
def test_a_glaze_spreads_from_one_end_to_the_other(end: float) -> None:
    place = end * LOOP.displacement_um / 60.0
    sizes = {"share": 0.2, "end": end, "cycles": 1e4}
    whole = factor_on_force(seen("spreading_glaze", BLOCK, 1e4, **sizes))
    assert whole == pytest.approx(0.8, abs=0.005)
    # After a quarter of the cycles it has come half of the way.
    half = factor_on_force(seen("spreading_glaze", BLOCK, 2.5e3, **sizes))
    assert half[place > 0.2] == pytest.approx(0.8, abs=0.005)
    assert half[place < -0.2] == pytest.approx(1.0, abs=0.005)
    assert factor_on_force(seen("spreading_glaze", BLOCK, 0.0, **sizes)) == pytest.approx(1.0, abs=0.005)


def test_a_leaf_snaps_over_at_its_force_and_takes_work() -> None:
    snapped = seen("snapping_leaf", STIFF, jump_um=6.0, force_N=0.6)
    # Shelves of 6 µm at ±0.6 N in place of as much sliding at 1.2 N.
    assert area_mJ(snapped) - area_mJ(STIFF) == pytest.approx(-2e-3 * 6.0 * 0.6, rel=0.1)
    for ahead, direction in ((slice(360, 720), -1.0), (slice(1080, 1440), 1.0)):
        shelf = np.abs(snapped.tangential_force_N[ahead] - direction * 0.6) < 0.05
        assert np.ptp(LOOP.displacement_um[ahead][shelf]) == pytest.approx(6.0, abs=0.8)
    elastic = seen("snapping_leaf", jump_um=6.0, force_N=2.0).tangential_force_N
    assert elastic == pytest.approx(LOOP.tangential_force_N, abs=1e-9)


@pytest.mark.parametrize("um_per_N", [6.0, -6.0])
def test_a_slide_gives_way_at_one_end_alone(um_per_N: float) -> None:
    later = np.abs(seen("telescoping_slide", um_per_N=um_per_N).tangential_force_N - LOOP.tangential_force_N)
    upper, lower = later[360:560].max(), later[1080:1280].max()
    softer, stiffer = (upper, lower) if um_per_N > 0.0 else (lower, upper)
    assert softer > 0.5
    assert stiffer < 0.15


def test_friction_turns_with_the_slip_where_the_holder_goes_round() -> None:
    turned = seen("orbiting_holder", STIFF, across=0.3).tangential_force_N
    there = np.cos(TURN) / np.hypot(np.cos(TURN), 0.3 * np.sin(TURN))
    assert turned == pytest.approx(1.2 * there, abs=0.1)
    # It begins to fall before the reversal, which no lag does.
    assert turned[340] < 0.9 * STIFF.tangential_force_N[340]


def test_a_servo_hunts_in_its_own_time_from_cycle_to_cycle() -> None:
    sizes = {"share": 0.1, "frequency_Hz": 10.0}
    loads = [seen("hunting_servo", LOOP, cycle, **sizes).normal_force_N for cycle in (100.0, 101.0, 103.0)]
    assert loads[0][0] == pytest.approx(2.0 * (1.0 + 0.1 * np.sin(2.0 * np.pi * 1000.0 / 3.0)))
    # Three and a third times a cycle: one cycle goes on where the last one ends, and the fourth is the first again.
    assert loads[1][0] == pytest.approx(loads[0][-1], abs=0.01)
    assert loads[2] == pytest.approx(loads[0])
    assert np.abs(loads[1] - loads[0]).max() > 0.2


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_stop_bears_load_towards_one_end_both_ways(side: float) -> None:
    stopped = seen("touching_stop", share=0.2 * side, begins=0.4)
    place = side * LOOP.displacement_um / 60.0
    assert stopped.normal_force_N[place < 0.4] == pytest.approx(2.0)
    assert stopped.normal_force_N[place.argmax()] == pytest.approx(1.6)
    assert stopped.normal_force_N[np.abs(place - 0.7) < 0.01] == pytest.approx(1.8, abs=0.01)


def test_a_slide_slips_at_square_multiples_of_its_first_cycle() -> None:
    hanging = Hanging(0.2, 100.0)
    assert [hanging.at(n) for n in (0.0, 25.0, 99.99, 100.0, 225.0, 399.9, 400.0)] == pytest.approx(
        [1.0, 0.9, 0.8, 1.0, 0.9, 0.8, 1.0], abs=2e-4
    )


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


def test_a_wire_put_back_turned_has_its_scar_aside_and_is_worn_in_anew() -> None:
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
