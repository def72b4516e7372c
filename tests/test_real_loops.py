"""Loops as rigs give them: play, stick-slip, static peaks and unequal friction are measured; points need no order."""

import itertools
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from tests.measured_loops import RealLoop
from tests.synthetic_loops import Recipe, SyntheticLoop
from wirewear.faces import cli
from wirewear.loops import LoopFigures, analyse_loop
from wirewear.records import read_record

#: Lengths and forces over which rigs go: micrometres and newtons, tenths of a millimetre, centimetres and kilonewtons.
SIZES = {"wire": (1.0, 1.0), "rod": (25.0, 240.0), "joint": (170.0, 1600.0)}
SOFT = RealLoop(stiffness_N_per_um=0.1)


def figures_of(loop: RealLoop, samples: int = 512, seed: int = 0) -> LoopFigures:
    time, displacement, force = loop.sampled(samples, seed)
    load = 2.0 * loop.friction_forward_N / 1.24
    return analyse_loop(displacement, force, load, time_s=time / 3.0)


@pytest.mark.parametrize("size", SIZES)
def test_play_with_chatter_offset_and_unequal_friction_is_measured_at_every_size(size: str) -> None:
    cases = itertools.product((4.0, 8.0), (0.0, 0.4), (0.0, 0.2), (1.24, 0.93))
    held = []
    for seed, (play, drop, offset, backward) in enumerate(cases):
        loop = replace(
            SOFT,
            play_um=play,
            chatter_drop=drop,
            force_offset_N=offset,
            friction_backward_N=backward,
            static_overshoot=0.15,
        ).scaled(*SIZES[size])
        figures = figures_of(loop, 512 if seed % 3 else 256, seed)
        assert figures.free_play_um is not None, loop
        assert figures.free_play_um.value == pytest.approx(loop.play_um, rel=0.1), loop
        held.append(figures.free_play_um.interval95[0] <= loop.play_um <= figures.free_play_um.interval95[1])
        assert figures.outlier_samples == ()
        assert (figures.stick_slip is not None) == (drop > 0.0)
        if (stiffness := figures.measured_stiffness_N_per_um) is not None:
            assert stiffness.value == pytest.approx(loop.stiffness_N_per_um, rel=0.05)
    assert np.mean(held) > 0.8


def test_without_play_none_is_found() -> None:
    for seed, samples in enumerate((64, 160, 256, 512)):
        for recipe in (Recipe(), Recipe(end_slope_rad=0.15, hook_power=3.0), Recipe(rig_stiffness=1e6)):
            _, displacement, force = SyntheticLoop(recipe).sampled(samples, 0.1 * seed)
            assert analyse_loop(displacement, force, 2.0).free_play_um is None


def test_play_of_an_independent_rig_is_found_and_none_where_it_has_none() -> None:
    records = Path("studies/steel_wires/example_records")
    loops = [loop for loop in read_record(records / "free_play_rig").loops if loop.cycle <= 1000]
    plays = [loop.figures(2.0).free_play_um for loop in loops]
    found = [play.value for play in plays if play is not None]
    assert len(found) >= 0.6 * len(loops)
    assert np.mean(found) == pytest.approx(4.0, rel=0.1)
    assert all(loop.figures(2.0).free_play_um is None for loop in read_record(records / "no_gap").loops)


def test_slip_and_friction_of_a_rig_with_play_are_those_of_its_contact() -> None:
    loop = replace(SOFT, play_um=6.0, noise_share=0.001)
    figures = figures_of(loop)
    lost = loop.friction_forward_N / loop.stiffness_N_per_um + 0.5 * loop.play_um
    assert figures.slip_amplitude_um.value == pytest.approx(loop.amplitude_um - lost, rel=0.003)
    assert figures.friction_energy is not None
    assert figures.friction_energy.value == pytest.approx(0.62, rel=0.01)


def test_friction_by_direction_counts_from_the_zero_that_the_shelf_shows() -> None:
    loop = replace(SOFT, play_um=6.0, friction_backward_N=0.9, force_offset_N=0.2)
    figures = figures_of(loop)
    assert figures.force_zero_N is not None
    assert figures.force_zero_N.value == pytest.approx(0.2, abs=0.01)
    assert figures.friction_forward is not None
    assert figures.friction_forward.value == pytest.approx(0.62, rel=0.01)
    assert figures.friction_backward is not None
    assert figures.friction_backward.value == pytest.approx(0.45, rel=0.01)


def test_stick_slip_is_told_by_its_share_frequency_and_fall() -> None:
    loop = replace(SOFT, chatter_drop=0.4)
    chatter = figures_of(loop).stick_slip
    assert chatter is not None
    assert chatter.resolved
    assert chatter.share > 0.85
    assert chatter.slips_per_cycle == pytest.approx(loop.chatter_events, rel=0.15)
    # Slips of a cycle over the time in which it slides; a cycle lasts a third of a second.
    assert chatter.frequency_Hz is not None
    assert 3.0 * chatter.slips_per_cycle < chatter.frequency_Hz < 6.0 * chatter.slips_per_cycle
    assert chatter.force_drop_share.value == pytest.approx(0.4, abs=0.05)


def test_chatter_faster_than_the_samples_is_said_to_be_a_lower_bound() -> None:
    chatter = figures_of(RealLoop(chatter_drop=0.15), 256).stick_slip
    assert chatter is not None
    assert not chatter.resolved


def test_a_static_peak_is_measured_and_no_outlier() -> None:
    figures = figures_of(replace(SOFT, static_overshoot=0.2))
    assert figures.outlier_samples == ()
    assert figures.static_overshoot is not None
    assert figures.static_overshoot.value == pytest.approx(0.2, abs=0.05)
    assert figures_of(SOFT).static_overshoot is None


def test_an_outlier_amid_stick_slip_is_still_one() -> None:
    time, displacement, force = replace(SOFT, chatter_drop=0.4).sampled()
    force[100] += 4.0
    assert analyse_loop(displacement, force, 2.0, time_s=time).outlier_samples == (100,)


def test_branches_that_are_no_lines_have_no_stiffness() -> None:
    _, displacement, force = RealLoop(noise_share=0.0).sampled()
    # A guide that is weak about zero force, with no clear end: neither a shelf nor a spring.
    bent = displacement + 12.0 * np.tanh(force / 0.6)
    figures = analyse_loop(bent, force, 2.0)
    assert figures.measured_stiffness_N_per_um is None
    assert any("not rise along a line" in note for note in figures.notes)


@pytest.mark.parametrize("order", ["shuffled", "by displacement", "branches the same way"])
def test_digitised_points_need_no_order(order: str) -> None:
    loop = SyntheticLoop(Recipe(end_slope_rad=0.15, hook_power=3.0))
    _, displacement, force = loop.sampled(120, 0.3)
    start, top = int(np.argmin(displacement)), int(np.argmax(displacement))
    turned = np.roll(np.arange(120), -start)
    forward = (top - start) % 120
    orders = {
        "shuffled": np.random.default_rng(1).permutation(120),
        "by displacement": np.argsort(displacement),
        "branches the same way": np.concatenate([turned[:forward], turned[forward:][::-1]]),
    }
    figures = analyse_loop(displacement[orders[order]], force[orders[order]], 2.0)
    assert figures.slip_amplitude_um.value == pytest.approx(loop.slip_amplitude_um, rel=0.005)
    assert figures.dissipated_energy_mJ.value == pytest.approx(loop.energy_mJ, rel=0.005)
    assert any("joined" in note for note in figures.notes)


def test_reversals_are_read_from_the_times_of_unevenly_spread_samples() -> None:
    # Increments of a simulation: short after each reversal, long before it.
    part = np.array([0.0, 0.004, 0.008, 0.013, 0.02, 0.026, 0.04, 0.06, 0.09, 0.13, 0.21, 0.29])
    times = np.sort(np.concatenate([0.25 + 1.3 * part, 0.75 + 1.3 * part]) % 1.0)
    _, displacement, force = SyntheticLoop(Recipe()).sampled(0, 0.0, times)
    told = analyse_loop(displacement, force, 2.0, time_s=times / 3.0)
    assert told.displacement_amplitude_um.value == pytest.approx(60.0, rel=1e-3)
    guessed = analyse_loop(displacement, force, 2.0)
    assert guessed.displacement_amplitude_um.value == pytest.approx(60.0, rel=5e-3)


def test_the_command_tells_play_and_chatter_with_their_units(tmp_path: Path) -> None:
    loop = replace(SOFT, play_um=6.0, chatter_drop=0.4)
    path = tmp_path / "real.csv"
    columns = np.stack(loop.sampled(), axis=1)
    np.savetxt(path, columns, delimiter=",", header="time_s,displacement_um,tangential_force_N", comments="")
    arguments = ["loops", str(path), "--normal-load", "2"]
    table = CliRunner().invoke(cli, [*arguments, "--output", str(tmp_path / "loops.png")]).stdout
    assert "[mJ]" in table
    assert "slips a" in table
    (found,) = json.loads(CliRunner().invoke(cli, [*arguments, "--json"]).stdout)["loops"]
    assert found["free_play_um"]["value"] == pytest.approx(6.0, rel=0.1)
    assert found["stick_slip"]["slips_per_cycle"] > 10
