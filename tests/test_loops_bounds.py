"""Figures of loops obey the bounds of physics, whatever rings, hooks or is read badly."""

from pathlib import Path

import numpy as np
import pytest

from tests.closed_form_loops import Disturbance, MasingLoop
from tests.synthetic_loops import Recipe, SyntheticLoop, disturbed
from wirewear.loops import LoopFigures, analyse_loop

AMPLITUDE_um, SLIDING_N = 2000.0, 2.08


def ringing(seed: int) -> LoopFigures:
    """46 samples a cycle of a drive with fast turns; the force slides at once and rings after each reversal."""
    random = np.random.default_rng(seed)
    phase = (np.arange(46) + random.random()) / 46
    displacement = -AMPLITUDE_um * np.cos(2.0 * np.pi * phase)
    since = (phase % 0.5) * 2.0
    ring = 2.4 * np.exp(-since / 0.25) * np.cos(np.pi * (46 * since / 2.0 + random.random()))
    force = np.where(phase % 1.0 < 0.5, 1.0, -1.0) * (SLIDING_N + ring) + 0.15 * random.standard_normal(46)
    return analyse_loop(displacement, force, 20.0, time_s=phase)


def assert_bounded(figures: LoopFigures) -> None:
    assert 0.0 <= figures.slip_amplitude_um.value <= figures.displacement_amplitude_um.value
    for ratio in (figures.energy_ratio, figures.system_free_ratio):
        assert ratio is None or 0.0 <= ratio.value <= 1.0
    if figures.friction_energy is not None and figures.friction_max is not None:
        assert 0.0 <= figures.friction_energy.value <= figures.friction_max.value


@pytest.mark.parametrize("seed", range(12))
def test_a_coarse_force_that_rings_after_reversals_keeps_its_slip_and_friction(seed: int) -> None:
    figures = ringing(seed)
    assert_bounded(figures)
    assert figures.slip_amplitude_um.value == pytest.approx(AMPLITUDE_um, rel=0.05)
    assert figures.friction_energy is not None
    assert figures.friction_energy.value == pytest.approx(SLIDING_N / 20.0, rel=0.15)


@pytest.mark.parametrize("friction", [0.001, 0.01, 0.05])
@pytest.mark.parametrize("rig_stiffness", [1e9, 167.0])
def test_slip_of_a_worn_contact_whose_hooks_rise_above_the_plateau_is_all_that_it_slides(
    friction: float, rig_stiffness: float
) -> None:
    loop = SyntheticLoop(Recipe(friction, end_slope_rad=0.15, hook_power=3.0, rig_stiffness=rig_stiffness))
    _, displacement, force = loop.sampled(200, 0.2)
    figures = analyse_loop(displacement, force, 2.0)
    assert figures.slip_amplitude_um.value == pytest.approx(loop.own_amplitude_um, rel=0.02)
    assert figures.friction_energy is not None
    assert figures.friction_energy.value == pytest.approx(friction, rel=0.02)
    assert any("energy over four times" in note for note in figures.notes)
    assert_bounded(figures)


@pytest.mark.parametrize("samples", [128, 200, 256])
@pytest.mark.parametrize("noise", [0.0, 0.003])
@pytest.mark.parametrize("rig_N_per_um", [1e6, 0.6])
@pytest.mark.parametrize("wall", [0.5, 1.0, 1.05, 1.3, 1.5, 1.7, 2.5])
def test_walls_higher_than_the_friction_are_no_play_and_leave_the_friction_within_its_interval(
    wall: float, rig_N_per_um: float, noise: float, samples: int
) -> None:
    loop = MasingLoop(0.6, 5.0, 60.0, 2.0, 1.5, rig_N_per_um, wall=wall)
    time, displacement, force = Disturbance(samples, phase=0.3, noise=noise).of(loop)
    figures = analyse_loop(displacement, force, loop.normal_force_N, time_s=time)
    assert figures.free_play_um is None
    assert figures.friction_energy is not None
    for figure, truth in (
        (figures.friction_energy, loop.friction),
        (figures.slip_amplitude_um, 1e3 * loop.energy_mJ / (4.0 * loop.limit_N)),
    ):
        assert figure.interval95[0] - 0.01 * truth <= truth <= figure.interval95[1] + 0.01 * truth


HOOKED = np.loadtxt(Path(__file__).parent / "data" / "loops_of_low_friction.csv", delimiter=",", skiprows=1)


def test_the_largest_ratio_in_partial_slip_is_the_loops_own_where_the_load_changes() -> None:
    time = np.arange(200) / 200
    force = 1.24 * 0.6 * np.sin(2.0 * np.pi * time)
    displacement = force / 0.2 - 0.2 * np.cos(2.0 * np.pi * time)
    load = 2.0 - 0.5 * np.cos(2.0 * np.pi * time)
    figures = analyse_loop(displacement, force, load, time_s=time)
    assert figures.regime == "partial slip"
    assert figures.friction_max is not None
    assert figures.friction_max.value == pytest.approx(float(np.max(np.abs(force) / load)), rel=1e-3)


@pytest.mark.parametrize("noise", [0.0, 0.005, 0.02])
@pytest.mark.parametrize("friction", [0.02, 0.6, 1.5])
def test_a_rectangular_loop_fills_its_box_and_no_more(friction: float, noise: float) -> None:
    _, displacement, force = SyntheticLoop(Recipe(friction, rig_stiffness=1e9, contact_stiffness=1e6)).sampled(120, 0.1)
    for seed in range(10):
        assert_bounded(analyse_loop(*disturbed(displacement, force, seed, noise, 0.0), 2.0))
