"""Figures of loops of known parameters: accuracy, corners, hooks, regimes of slip, play and chatter."""

import itertools
import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests import synthetic_results
from tests.commands import wirewear
from tests.synthetic_loops import (
    RealLoop,
    Recipe,
    SyntheticLoop,
    analysed_with_noise,
    disturbed,
    drawn,
    hooked,
    partial_slip_loop,
    share_off,
)
from wirewear.loops import LoopFigures, analyse_loop
from wirewear.loops.noise import clipped
from wirewear.results import write_result

LOOP = SyntheticLoop(Recipe())


def noisy(samples: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    _, displacement, force = LOOP.sampled(samples, 0.2)
    return disturbed(displacement, force, seed, 0.005, 0.0)


@pytest.mark.parametrize("samples", [40, 128, 400])
@pytest.mark.parametrize("rig_stiffness", [167.0, 1e9])
def test_a_noiseless_plateau_is_not_called_clipped(samples: int, rig_stiffness: float) -> None:
    _, displacement, force = SyntheticLoop(Recipe(rig_stiffness=rig_stiffness)).sampled(samples, 0.2)
    assert not any("clipped" in note for note in analyse_loop(displacement, force, 2.0).notes)
    assert not any("clipped" in note for note in analyse_loop(np.clip(displacement, -50.0, 50.0), force, 2.0).notes)


@pytest.mark.parametrize("steps_a_peak", [60.0, 130.0, 250.0])
def test_a_plateau_read_in_coarse_steps_of_four_digits_is_not_called_clipped(steps_a_peak: float) -> None:
    """A stop stays where it is: a plateau about it is read beyond it, too, by a step."""
    found = []
    for seed in range(40):
        displacement, force = noisy(180, seed)
        step = float(np.abs(force).max()) / steps_a_peak
        found.append(clipped(np.round(step * np.round(force / step), 4), beside=displacement))
    assert sum(one is not None and one.sure for one in found) <= 1
    assert sum(one is not None for one in found) <= 14


@pytest.mark.parametrize("steps_of_noise", [0.5, 1.0, 2.0, 4.0])
def test_a_drive_read_in_coarse_steps_is_not_called_clipped_and_one_that_is_cut_off_is(steps_of_noise: float) -> None:
    random = np.random.default_rng(1)
    cut = whole = 0
    for samples in range(100, 300, 2):
        phase = 2.0 * np.pi * (np.arange(samples) + random.random()) / samples
        drive, step = np.sin(phase) + 0.002 * random.standard_normal(samples), 0.002 * steps_of_noise
        force = np.sign(np.cos(phase)) + 0.01 * random.standard_normal(samples)
        whole += clipped(step * np.round(drive / step), beside=force) is not None
        cut += clipped(step * np.round(np.minimum(drive, 0.95) / step), beside=force) is not None
    assert whole <= 2
    assert cut == 100


@pytest.mark.seconds
def test_noise_and_outliers_leave_slip_and_energy_within_one_percent_and_stiffness_within_five() -> None:
    # The noise is 1 % of the stroke and of the sliding force: the slope of less micro-slip cannot be measured to 5 %.
    for recipe, phase, seed in drawn(40, 0.1, seed=1):
        loop, figures = analysed_with_noise(recipe, phase, seed)
        assert figures.regime == "gross slip", recipe
        assert share_off(figures.displacement_amplitude_um, recipe.amplitude_um) < 0.01, recipe
        assert share_off(figures.slip_amplitude_um, loop.slip_amplitude_um) < 0.01, recipe
        assert share_off(figures.dissipated_energy_mJ, loop.energy_mJ) < 0.01, recipe
        assert share_off(figures.measured_stiffness_N_per_um, loop.stiffness_N_per_um) < 0.05, recipe


@pytest.mark.seconds
def test_geometry_independent_friction_is_within_one_percent_whatever_the_hooks() -> None:
    for recipe, phase, seed in drawn(50, 0.02, seed=2):
        _, figures = analysed_with_noise(recipe, phase, seed)
        assert share_off(figures.friction_geometry_independent, recipe.friction) < 0.01, recipe


@pytest.mark.seconds
def test_coarse_simulated_loops_give_slip_and_energy_within_half_a_percent() -> None:
    for recipe, phase, seed in drawn(40, 0.02, seed=3):
        loop = SyntheticLoop(recipe)
        _, displacement, force = loop.sampled(40 + seed % 41, phase)
        figures = analyse_loop(displacement, force, recipe.normal_load_N)
        assert share_off(figures.slip_amplitude_um, loop.slip_amplitude_um) < 0.005, recipe
        assert share_off(figures.dissipated_energy_mJ, loop.energy_mJ) < 0.005, recipe


@pytest.mark.parametrize(("samples", "rig_stiffness", "coarse"), [(40, 1e9, 2), (400, 1e9, 0), (40, 167.0, 0)])
def test_a_stiffness_from_few_samples_is_noted_by_branch(samples: int, rig_stiffness: float, coarse: int) -> None:
    _, displacement, force = SyntheticLoop(Recipe(rig_stiffness=rig_stiffness)).sampled(samples, 0.2)
    notes = analyse_loop(displacement, force, 2.0).notes
    assert sum("its stiffness is coarse" in note for note in notes) == coarse


@pytest.mark.parametrize("rig_stiffness", [100.0, 400.0, 1600.0])
@pytest.mark.parametrize("contact_stiffness", [1000.0, 2700.0, 10000.0])
def test_corner_curvature_separates_a_round_from_a_sharp_corner(rig_stiffness: float, contact_stiffness: float) -> None:
    recipe = Recipe(rig_stiffness=rig_stiffness, contact_stiffness=contact_stiffness)
    _, displacement, force = SyntheticLoop(recipe).sampled(256)
    figure = analyse_loop(displacement, force, 2.0).corner_curvature
    assert figure is not None
    # A spring 1/K_s in series with a contact that gives way by 1.5/K_c until it slides.
    contact = 1.5 / contact_stiffness
    share = contact / (contact + 1.0 / rig_stiffness)
    assert figure.value == pytest.approx(2.0 * share / 15.0 / (1.0 - share / 3.0), abs=5e-4)


def test_hooks_and_largest_friction_are_those_of_the_scars_ends() -> None:
    displacement, force = hooked()
    figures = analyse_loop(displacement, force, 2.0)
    tip = math.tan(math.atan(0.62) + 0.15)
    assert share_off(figures.friction_max, tip) < 0.02
    assert share_off(figures.end_hook_ratio, tip / 0.62) < 0.02


@pytest.mark.parametrize("ratio", [0.2, 0.5, 0.8, 0.95])
@pytest.mark.parametrize("noise", [0.0, 0.005])
def test_partial_slip_is_recognised_and_figures_of_sliding_are_left_out(ratio: float, noise: float) -> None:
    time, displacement, force = partial_slip_loop(ratio, 200)
    displacement, force = disturbed(displacement, force, 7, noise, 0.0)
    figures = analyse_loop(displacement, force, 2.0, time_s=time)
    assert figures.regime == "partial slip"
    assert figures.friction_geometry_independent is None
    assert figures.friction_energy is None
    assert figures.plateau_slope_N_per_um is None
    assert figures.end_hook_ratio is None
    assert figures.corner_curvature is None
    assert share_off(figures.friction_max, ratio * 0.62) < 0.01
    assert any("partial slip" in note for note in figures.notes)


@pytest.mark.parametrize("excess", [1.5, 2.0, 4.0])
@pytest.mark.parametrize("rig_stiffness", [167.0, 1e6])
def test_gross_slip_is_recognised_soon_after_it_begins(excess: float, rig_stiffness: float) -> None:
    threshold = 1240.0 / rig_stiffness + 1.5 * 1240.0 / 2718.0
    loop = SyntheticLoop(Recipe(amplitude_um=excess * threshold, rig_stiffness=rig_stiffness))
    _, displacement, force = loop.sampled(256)
    assert analyse_loop(*disturbed(displacement, force, 9), 2.0).regime == "gross slip"


def test_the_criteria_of_sliding_have_their_values_at_the_transition_and_on_a_rectangle() -> None:
    time, displacement, force = partial_slip_loop(0.9999, 800, rig_stiffness=1e9)
    at = analyse_loop(displacement, force, 2.0, time_s=time)
    assert share_off(at.energy_ratio, 0.2) < 0.01
    assert share_off(at.system_free_ratio, 0.77) < 0.02
    # What a soft rig takes lowers A alone.
    time, displacement, force = partial_slip_loop(0.9999, 800, rig_stiffness=167.0)
    soft = analyse_loop(displacement, force, 2.0, time_s=time)
    assert soft.energy_ratio is not None
    assert soft.energy_ratio.value < 0.05
    assert share_off(soft.system_free_ratio, 0.77) < 0.03
    phase = 2.0 * math.pi * (np.arange(60) + 0.5) / 60
    slides = analyse_loop(50.0 * np.sin(phase), np.sign(np.cos(phase)), 2.0)
    assert share_off(slides.energy_ratio, 1.0) < 0.01
    assert share_off(slides.system_free_ratio, 1.0) < 0.01


#: Lengths and forces over which rigs go: micrometres and newtons, tenths of a millimetre, centimetres and kilonewtons.
SIZES = {"joint": (170.0, 1600.0), "rod": (25.0, 240.0), "wire": (1.0, 1.0)}
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
            SOFT, play_um=play, chatter_drop=drop, force_offset_N=offset, friction_backward_N=backward,
            static_overshoot=0.15,
        ).scaled(*SIZES[size])  # fmt: skip
        figures = figures_of(loop, 512 if seed % 3 else 256, seed)
        assert figures.free_play_um is not None, loop
        assert figures.free_play_um.value == pytest.approx(loop.play_um, rel=0.1), loop
        held.append(figures.free_play_um.interval95[0] <= loop.play_um <= figures.free_play_um.interval95[1])
        assert figures.outlier_samples == ()
        assert (figures.stick_slip is not None) == (drop > 0.0)
        if (stiffness := figures.measured_stiffness_N_per_um) is not None:
            assert stiffness.value == pytest.approx(loop.stiffness_N_per_um, rel=0.05)
    assert np.mean(held) > 0.8


def test_slip_and_friction_of_a_rig_with_play_are_those_of_its_contact() -> None:
    loop = replace(SOFT, play_um=6.0, noise_share=0.001)
    figures = figures_of(loop)
    lost = loop.friction_forward_N / loop.stiffness_N_per_um + 0.5 * loop.play_um
    assert figures.slip_amplitude_um.value == pytest.approx(loop.amplitude_um - lost, rel=0.003)
    assert figures.friction_energy is not None
    assert figures.friction_energy.value == pytest.approx(0.62, rel=0.01)


def test_stick_slip_is_described_by_its_share_frequency_and_fall() -> None:
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


KEYS = (
    "displacement_amplitude_um", "slip_amplitude_um", "measured_stiffness_N_per_um", "friction_max", "friction_energy",
    "friction_geometry_independent", "dissipated_energy_mJ", "regime",
)  # fmt: skip
HOOKED = SyntheticLoop(Recipe(end_slope_rad=0.1, hook_power=3.0))
TIME, DISPLACEMENT_um, FORCE_N = HOOKED.sampled(200, 0.3)


def csv(path: Path, **columns: np.ndarray) -> Path:
    np.savetxt(path, np.stack(list(columns.values()), axis=1), delimiter=",", header=",".join(columns), comments="")
    return path


def test_json_has_the_fixed_keys_with_value_and_interval(tmp_path: Path) -> None:
    path = csv(tmp_path / "a.csv", displacement_um=DISPLACEMENT_um, tangential_force_N=FORCE_N)
    (loop,) = json.loads(wirewear("loops", path, "--normal-load", "2", "--json").stdout)["loops"]
    assert all(set(loop[key]) == {"value", "interval95"} for key in KEYS)
    assert loop["regime"]["value"] == "gross slip"
    assert loop["slip_amplitude_um"]["value"] == pytest.approx(HOOKED.slip_amplitude_um, rel=0.005)
    assert loop["friction_geometry_independent"]["value"] == pytest.approx(0.62, rel=0.005)


@pytest.mark.seconds
def test_a_result_gives_its_loops_a_table_and_a_picture(tmp_path: Path) -> None:
    path = tmp_path / "result.h5"
    write_result(path, synthetic_results.result("compliant", 167.0))
    result = wirewear("loops", path, "--output", tmp_path / "loops.png")
    assert "gross" in result.stdout
    assert "±" in result.stdout
    assert not re.search(r"± 0(?![.\d])", result.stdout)
    assert (tmp_path / "loops.png").read_bytes().startswith(b"\x89PNG")
