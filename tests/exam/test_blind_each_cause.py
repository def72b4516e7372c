"""Causes of no library that are read of a loop, each by itself: what its channels show is what its name says."""

from dataclasses import replace

import numpy as np
import pytest

from geometry.arrays import Array
from studies.blind.causes import causes_of
from studies.blind.generators.signals import Signals
from studies.blind.generators.strokes import since_reversal
from tests.exam.blind_causes import BACK, BLOCK, FORTH, LOOP, READ, TURN, area_mJ, drawn, seen

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


def test_a_heavy_holder_rings_at_its_own_frequency_and_hysteresis_is_widest_in_mid_stroke() -> None:
    rung = seen("ringing_force_cell", natural_frequency_Hz=45.0, damping=0.05).tangential_force_N
    gained = np.abs(np.fft.rfft(rung))[[1, 15]] / np.abs(np.fft.rfft(LOOP.tangential_force_N))[[1, 15]]
    assert gained == pytest.approx([1.0 / (1.0 - 1.0 / 225.0), 10.0], rel=1e-3)
    lag = LOOP.displacement_um - seen("hysteretic_displacement", share=0.1).displacement_um
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


def test_a_sticking_lever_takes_no_work_and_weights_bounce_twice_a_cycle() -> None:
    stuck = seen("sticking_lever", share=0.1, over_um=6.0)
    assert stuck.normal_force_N[[0, 720]] == pytest.approx([2.2, 1.8])
    assert area_mJ(stuck) == pytest.approx(area_mJ(LOOP), rel=1e-6)
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


@pytest.mark.parametrize("effect", sorted({*READ} & {*causes_of("withheld")} - {"rattling_weight", "averaging_logger"}))
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


def factor_on_force(found: Signals, of: Signals = BLOCK) -> Array:
    return np.asarray(found.tangential_force_N / of.tangential_force_N)


@pytest.mark.parametrize("effect", sorted({*READ} & {*causes_of("reserved")}))
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
    assert turned == pytest.approx(1.2 * (np.cos(TURN) / np.hypot(np.cos(TURN), 0.3 * np.sin(TURN))), abs=0.1)
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
