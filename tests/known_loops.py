"""Synthetic loops whose figures are known: of many recipes, and one with hooks at the ends of its stroke."""

import math
from collections.abc import Iterator

import numpy as np

from tests.synthetic_loops import Recipe, SyntheticLoop, disturbed
from wirewear.loops import LoopFigures, Measured, analyse_loop


def recipe_of(
    friction: float,
    normal_load_N: float,
    amplitude_um: float,
    micro_slip: float,
    contact_share: float,
    end_slope_rad: float,
    hook_power: float,
) -> Recipe:
    """Micro-slip takes that part of the amplitude, and the contact that share of it, the rig the rest."""
    travel_mm_per_N = 1e-3 * micro_slip * amplitude_um / (friction * normal_load_N)
    return Recipe(
        friction=friction,
        normal_load_N=normal_load_N,
        amplitude_um=amplitude_um,
        contact_stiffness=1.5 / (travel_mm_per_N * contact_share),
        rig_stiffness=1.0 / (travel_mm_per_N * (1.0 - contact_share)),
        end_slope_rad=end_slope_rad,
        hook_power=hook_power,
    )


def hook_ratio(recipe: Recipe) -> float:
    return math.tan(math.atan(recipe.friction) + recipe.end_slope_rad) / recipe.friction


def drawn(count: int, least_micro_slip: float, seed: int) -> Iterator[tuple[Recipe, float, int]]:
    """Gross slip with hooks up to half as high again as the plateau; micro-slip up to 30 % of the amplitude.

    Each with a phase and a seed of its noise; the same ones in every session, as one in thousands is beyond the limits.
    """
    random = np.random.default_rng(seed)
    while count:
        recipe = recipe_of(
            friction=random.uniform(0.2, 1.1),
            normal_load_N=random.uniform(0.5, 20.0),
            amplitude_um=random.uniform(10.0, 200.0),
            micro_slip=random.uniform(least_micro_slip, 0.3),
            contact_share=random.uniform(0.01, 0.9),
            end_slope_rad=random.uniform(0.0, 0.2),
            hook_power=random.uniform(1.0, 6.0),
        )
        if hook_ratio(recipe) < 1.5:
            count -= 1
            yield recipe, random.random(), int(random.integers(10**6))


def share_off(figure: Measured | None, truth: float) -> float:
    assert figure is not None
    return abs(figure.value / truth - 1.0)


def analysed_with_noise(recipe: Recipe, phase: float, seed: int) -> tuple[SyntheticLoop, LoopFigures]:
    loop = SyntheticLoop(recipe)
    time, displacement, force = loop.sampled(256, phase)
    sliding_force = recipe.friction * recipe.normal_load_N
    displacement, force = disturbed(displacement, force, seed, force_scale=sliding_force)
    return loop, analyse_loop(displacement, force, recipe.normal_load_N, time_s=time)


HOOKED = SyntheticLoop(Recipe(end_slope_rad=0.15, hook_power=3.0))


def hooked(samples: int = 256, phase: float = 0.37, seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    _, displacement, force = HOOKED.sampled(samples, phase)
    return disturbed(displacement, force, seed, force_scale=1.24)


def assert_known(figures: LoopFigures, stiffness_within: float = 0.05) -> None:
    assert share_off(figures.slip_amplitude_um, HOOKED.slip_amplitude_um) < 0.01
    assert share_off(figures.dissipated_energy_mJ, HOOKED.energy_mJ) < 0.01
    assert share_off(figures.measured_stiffness_N_per_um, HOOKED.stiffness_N_per_um) < stiffness_within
    assert share_off(figures.friction_geometry_independent, 0.62) < 0.01
