"""Causes of the reserved set: at all seams, the same again, without a trace, in both tiers alike, and how large."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from geometry.arrays import Array
from studies.blind.generators.ageing import Hanging
from studies.blind.generators.generator import LIBRARY_EFFECTS
from studies.blind.generators.independent.effects import changed
from studies.blind.generators.independent.reserved import RESERVED
from studies.blind.generators.independent.unknown_causes import OUTSIDE_SETS
from studies.blind.generators.independent.wear_test import grid_of, snapshots
from studies.blind.generators.instruments import Signals
from studies.blind.generators.sizes import DRAWS
from studies.blind.generators.strokes import since_reversal
from studies.blind.scoring.seams import OUTSIDE_SEAMS
from tests.reserved_causes import AT_SEAMS, LOADS, NOTHING, ONE_WAY_IN_DISPLACEMENT, ONE_WAY_IN_FORCE, READ
from tests.test_blind_unseen import LOOP, STEEL, TURN, area_mJ, require_read_alike
from tests.withheld_causes import (
    drawn,
    gaps_in_scatters,
    require_alike_at_seams,
    require_traceless,
    require_untouched,
    seen,
    worn,
)
from wirewear.effects import Seam

#: A block that slides on Coulomb friction without any give; one whose spring turns within 0.6 µm.
BLOCK = replace(LOOP, tangential_force_N=np.asarray(1.2 * np.sign(np.cos(TURN + 1e-9))))
PASSED, DIRECTION = since_reversal(LOOP)
STIFF = replace(LOOP, tangential_force_N=np.asarray(1.2 * DIRECTION * np.clip(PASSED / 0.3 - 1.0, -1.0, 1.0)))
FORTH, BACK = np.cos(TURN) > 0.05, np.cos(TURN) < -0.05


def factor_on_force(found: Signals, of: Signals = BLOCK) -> Array:
    return np.asarray(found.tangential_force_N / of.tangential_force_N)


def unevenness(values: Array) -> float:
    """How far a channel is from being odd over half a cycle."""
    return float(np.abs(values + np.roll(values, values.size // 2)).max() / np.abs(values).max())


@pytest.mark.parametrize("effect", READ)
def test_a_loop_stays_odd_over_half_a_cycle_but_where_one_end_differs(effect: str) -> None:
    found = seen(effect, LOOP, 3e4, **drawn(effect))
    for values, one_way in (
        (found.tangential_force_N, ONE_WAY_IN_FORCE),
        (found.displacement_um, ONE_WAY_IN_DISPLACEMENT),
    ):
        assert (unevenness(values) > 1e-3) if effect in one_way else (unevenness(values) < 1e-9)


@pytest.mark.parametrize("effect", READ)
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


def test_there_are_fourteen_kinds_and_more_at_all_seams_that_no_other_set_has() -> None:
    seams = [OUTSIDE_SEAMS[effect] for effect in RESERVED]
    assert len(RESERVED) >= 14
    assert all(seams.count(seam) >= 2 for seam in ("sensor", "contact", "holder", "loading"))
    assert set(seams) == set(Seam)
    assert set(NOTHING) == set(RESERVED) <= set(DRAWS)
    earlier = {effect for name, kinds in OUTSIDE_SETS.items() if name != "reserved" for effect in kinds}
    assert not set(RESERVED) & {*earlier, *LIBRARY_EFFECTS}


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize("effect", RESERVED)
def test_records_are_the_same_again_and_their_files_of_one_size_without_the_cause(effect: str, tmp_path: Path) -> None:
    require_traceless(effect, RESERVED, tmp_path)


@pytest.mark.parametrize("effect", RESERVED)
def test_a_cause_of_no_size_leaves_the_test_as_it_is(effect: str) -> None:
    require_untouched(effect, NOTHING[effect])


@pytest.mark.parametrize("effect", READ)
def test_both_tiers_read_the_same_of_the_same_loop(effect: str) -> None:
    require_read_alike(effect, drawn(effect))


@pytest.mark.parametrize("effect", AT_SEAMS)
def test_both_tiers_have_the_same_holder_friction_load_and_wear_at_every_cycle(effect: str) -> None:
    require_alike_at_seams(effect)


@pytest.mark.slow
@pytest.mark.parametrize("effect", RESERVED)
def test_sizes_of_gaps_lie_about_two_to_twenty_scatters(effect: str) -> None:
    size = gaps_in_scatters(effect, points=24)
    assert size["hard"] < size["easy"]
    assert 0.5 < size["hard"] < 8.0
    assert 3.5 < size["easy"] < 40.0
