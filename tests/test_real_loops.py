"""Loops as rigs give them: play, stick-slip, static peaks and unequal friction are measured; points need no order."""

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.measured_loops import RealLoop
from wirewear.loops import LoopFigures, analyse_loop
from wirewear.records import read_record

#: Lengths and forces over which rigs go: micrometres and newtons, tenths of a millimetre, centimetres and kilonewtons.
SIZES = {"wire": (1.0, 1.0), "rod": (25.0, 240.0), "joint": (170.0, 1600.0)}
SOFT = RealLoop(stiffness_N_per_um=0.1)


def figures_of(loop: RealLoop, samples: int = 512, seed: int = 0) -> LoopFigures:
    time, displacement, force = loop.sampled(samples, seed)
    load = 2.0 * loop.friction_forward_N / 1.24
    return analyse_loop(displacement, force, load, time_s=time / 3.0)


@pytest.mark.first_case
@pytest.mark.seconds
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


@pytest.mark.seconds
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


def test_a_static_peak_is_measured_and_no_outlier() -> None:
    figures = figures_of(replace(SOFT, static_overshoot=0.2))
    assert figures.outlier_samples == ()
    assert figures.static_overshoot is not None
    assert figures.static_overshoot.value == pytest.approx(0.2, abs=0.05)
    assert figures_of(SOFT).static_overshoot is None
