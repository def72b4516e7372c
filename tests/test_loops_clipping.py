"""Clipped channels are told from plateaus that are flat: refused or noted, never taken for a measurement."""

import numpy as np
import pytest

from tests.synthetic_loops import Recipe, SyntheticLoop, disturbed
from wirewear.loops import LoopError, analyse_loop

LOOP = SyntheticLoop(Recipe())


def noisy(samples: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    _, displacement, force = LOOP.sampled(samples, 0.2)
    return disturbed(displacement, force, seed, 0.005, 0.0)


@pytest.mark.parametrize("samples", [48, 128, 256])
@pytest.mark.parametrize(("low", "high"), [(-0.9, 0.9), (-9.0, 0.9), (-0.9, 9.0), (-1.1, 0.8)])
def test_a_clipped_force_is_refused_in_a_sentence(samples: int, low: float, high: float) -> None:
    displacement, force = noisy(samples)
    with pytest.raises(LoopError, match="tangential force is clipped"):
        analyse_loop(displacement, np.clip(force, low, high), 2.0)


def test_a_clipped_displacement_is_refused_in_a_sentence() -> None:
    displacement, force = noisy(256)
    with pytest.raises(LoopError, match="displacement is clipped"):
        analyse_loop(np.clip(displacement, -50.0, 99.0), force, 2.0)


def test_without_a_clipped_normal_force_friction_is_left_out() -> None:
    displacement, force = noisy(256)
    load = np.minimum(2.0 + 0.05 * np.random.default_rng(2).standard_normal(256), 2.02)
    figures = analyse_loop(displacement, force, load)
    assert figures.friction_energy is None
    assert any("normal force is clipped" in note for note in figures.notes)
    assert figures.dissipated_energy_mJ.value == pytest.approx(LOOP.energy_mJ, rel=0.01)


def test_a_normal_force_that_varies_by_a_simulations_tolerance_is_constant() -> None:
    displacement, force = noisy(256)
    load = 2.0 + 4e-9 * np.random.default_rng(2).standard_normal(256)
    clipped = analyse_loop(displacement, force, np.clip(load, 2.0 - 4e-9, 2.0 + 4e-9))
    assert clipped.notes == analyse_loop(displacement, force, 2.0).notes
    assert clipped.friction_max is not None


@pytest.mark.parametrize("samples", [40, 128, 400])
@pytest.mark.parametrize("rig_stiffness", [167.0, 1e9])
def test_a_noiseless_plateau_is_not_called_clipped(samples: int, rig_stiffness: float) -> None:
    _, displacement, force = SyntheticLoop(Recipe(rig_stiffness=rig_stiffness)).sampled(samples, 0.2)
    assert not any("clipped" in note for note in analyse_loop(displacement, force, 2.0).notes)
    assert not any("clipped" in note for note in analyse_loop(np.clip(displacement, -50.0, 50.0), force, 2.0).notes)


def test_coarse_steps_of_a_converter_are_not_called_clipped() -> None:
    displacement, force = noisy(256)
    figures = analyse_loop(displacement, 0.05 * np.round(force / 0.05), 2.0)
    assert not any("clipped" in note for note in figures.notes)


def test_a_normal_force_that_only_rounding_varies_is_not_called_clipped() -> None:
    displacement, force = noisy(256)
    load = np.where(np.arange(256) % 7 < 5, 2.0, np.nextafter(2.0, 3.0))
    figures = analyse_loop(displacement, force, load)
    assert figures.notes == ()
    assert figures.friction_energy is not None
