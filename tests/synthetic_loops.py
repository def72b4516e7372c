"""Fretting loops of known parameters: Mindlin contact, rig spring, scar slope, noise and outliers."""

import math
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array
from wirewear.reference import PartialSlipPoint, branch_force, displacement_after_reversal


@dataclass(frozen=True)
class Recipe:
    """A loop's parameters: scar slope θ(x) = end_slope_rad · sign(x)|x/x_a|^hook_power over the slip x; K in N/mm."""

    friction: float = 0.62
    normal_load_N: float = 2.0
    amplitude_um: float = 60.0
    contact_stiffness: float = 2718.0
    rig_stiffness: float = 167.0
    end_slope_rad: float = 0.0
    hook_power: float = 1.0


class SyntheticLoop:
    """The loop as two branches δ(y), Q(y) over the contact's own displacement y, finely resolved, in µm and N."""

    def __init__(self, recipe: Recipe) -> None:
        self.recipe = recipe
        contact = PartialSlipPoint(recipe.normal_load_N, recipe.friction, 1.0, recipe.contact_stiffness)
        self.slides_within_um = 1e3 * contact.full_slip_displacement_mm
        if recipe.end_slope_rad == 0.0:
            tip_N = contact.limit_N
        else:
            tip_N = recipe.normal_load_N * math.tan(math.atan(recipe.friction) + recipe.end_slope_rad)
        self.own_amplitude_um = recipe.amplitude_um - 1e3 * tip_N / recipe.rig_stiffness
        ya = self.own_amplitude_um
        if ya <= self.slides_within_um:
            raise ValueError("this recipe does not slide")
        turn = np.linspace(0.0, math.pi, 4001)
        y = -ya * np.cos(turn)
        mobilised = branch_force(contact, y * 1e-3, ya * 1e-3, forward=True) / contact.limit_N
        self.own_um = y
        self.force_N = self._force(y, mobilised)
        self.displacement_um = y + 1e3 * self.force_N / recipe.rig_stiffness

    def _force(self, y: Array, mobilised: Array) -> Array:
        """Force of the forward branch: between the limits of both directions as far as friction is mobilised."""
        recipe = self.recipe
        phi = math.atan(recipe.friction)
        slip = y - self.slides_within_um * mobilised
        reach = self.own_amplitude_um - self.slides_within_um
        theta = recipe.end_slope_rad * np.sign(slip) * np.abs(slip / reach) ** recipe.hook_power
        up, down = np.tan(phi + theta), np.tan(phi - theta)
        force: Array = recipe.normal_load_N * (0.5 * up * (1.0 + mobilised) - 0.5 * down * (1.0 - mobilised))
        return force

    @property
    def energy_mJ(self) -> float:
        return 2.0 * float(np.trapezoid(self.force_N, self.displacement_um)) * 1e-3

    @property
    def slip_amplitude_um(self) -> float:
        return -float(np.interp(0.0, self.force_N, self.displacement_um))

    @property
    def stiffness_N_per_um(self) -> float:
        """Slope of the least-squares line over half of the micro-slip region (evenly resolved)."""
        region = self.own_um + self.own_amplitude_um <= 2.0 * self.slides_within_um
        end = self.displacement_um[region][-1]
        even = np.linspace(self.displacement_um[0], 0.5 * (self.displacement_um[0] + end), 2001)
        return float(np.polyfit(even, np.interp(even, self.displacement_um, self.force_N), 1)[0])

    def sampled(self, samples: int, phase: float = 0.0, times: Array | None = None) -> tuple[Array, Array, Array]:
        """Time in cycles, displacement and force under a sinusoidal drive."""
        time = np.arange(samples) / samples if times is None else times
        angle = 2.0 * np.pi * (time + phase)
        displacement = self.recipe.amplitude_um * np.sin(angle)
        forward = np.cos(angle) >= 0.0
        sign = np.where(forward, 1.0, -1.0)
        force = sign * np.interp(sign * displacement, self.displacement_um, self.force_N)
        return time, displacement, force


def disturbed(
    displacement: Array,
    force: Array,
    seed: int,
    noise: float = 0.01,
    outlier_share: float = 0.005,
    force_scale: float | None = None,
) -> tuple[Array, Array]:
    """Gaussian noise on both channels, in shares of the amplitude and of force_scale (largest force), and outliers."""
    random = np.random.default_rng(seed)
    channels = []
    largest = float(np.abs(force).max())
    for clean, size in ((displacement, float(np.abs(displacement).max())), (force, force_scale or largest)):
        noisy = clean + noise * size * random.standard_normal(len(clean))
        spoiled = random.random(len(clean)) < outlier_share
        jump = random.choice([-1.0, 1.0], len(clean)) * random.uniform(0.5, 3.0, len(clean)) * size
        channels.append(noisy + np.where(spoiled, jump, 0.0))
    return channels[0], channels[1]


def partial_slip_loop(ratio: float, samples: int, rig_stiffness: float = 167.0) -> tuple[Array, Array, Array]:
    """Force-driven loop between ±ratio·µP: time, displacement (µm) and force (N)."""
    contact = PartialSlipPoint(2.0, 0.62, 1.0, 2718.0)
    time = np.arange(samples) / samples
    peak = ratio * contact.limit_N
    force = peak * np.sin(2.0 * np.pi * time)
    sign = np.where(np.cos(2.0 * np.pi * time) >= 0.0, 1.0, -1.0)
    own = sign * displacement_after_reversal(contact, sign * force, -peak)
    return time, 1e3 * (own + force / rig_stiffness), force
