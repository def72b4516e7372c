"""Fretting loops of known figures: Mindlin contact and scar slope; sliders with play and chatter."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array
from wirewear.loops import LoopFigures, Measured, analyse_loop
from wirewear.reference import PartialSlipPoint, branch_force, loading_displacement


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
        y = -ya * np.cos(np.linspace(0.0, math.pi, 4001))
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
        sign = np.where(np.cos(angle) >= 0.0, 1.0, -1.0)
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
    own = 2.0 * loading_displacement(contact, 0.5 * (peak + sign * force)) - loading_displacement(contact, peak)
    return time, 1e3 * (sign * own + force / rig_stiffness), force


def bristle_loop(
    limit_N: float, share: float, seed: int, contact_um_per_N: float, rig_um_per_N: float
) -> tuple[Array, Array, Array]:
    """Time, displacement (µm) and force (N) between ±share·µP, with noise, a drift and a part of a sample's lag.

    Bristles of one stiffness, whose limits are evenly spread, are dragged to and fro behind a rig.
    """
    limits = np.linspace(0.0, 1.0, 2000)
    limits *= limit_N / limits.sum()
    stiffness = 1.0 / (contact_um_per_N * limits.size)
    amplitude = limits[-1] / stiffness * (1.0 - math.sqrt(1.0 - share))
    path = 2.0 * amplitude * np.sin(np.linspace(0.0, math.pi / 2.0, 80)) ** 2 - amplitude
    anchors, forces = np.zeros(limits.size), []
    for displacement in (*np.linspace(0.0, amplitude, 30), *path[::-1], *path):
        held = np.clip(stiffness * (displacement - anchors), -limits, limits)
        anchors = displacement - held / stiffness
        forces.append(float(held.sum()))
    rise = np.array(forces[-path.size :]) - forces[-path.size]
    travel = path - path[0] + rig_um_per_N * rise
    random, count = np.random.default_rng(seed), 240
    time = np.arange(count) / count
    half, force_N = 0.5 * travel[-1], 0.5 * rise[-1]
    angle = 2.0 * math.pi * time + 0.3
    late = angle - 2.0 * math.pi * random.uniform(-0.3, 0.3) / count
    forward = np.interp(half * (1.0 + np.sin(late)), travel, rise) - force_N
    backward = force_N - np.interp(half * (1.0 - np.sin(late)), travel, rise)
    force = np.where(np.cos(late) >= 0.0, forward, backward) + 0.004 * force_N * random.standard_normal(count)
    return time, half * (np.sin(angle) + 0.004 * random.standard_normal(count) + 0.002 * time), force


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
        friction=friction, normal_load_N=normal_load_N, amplitude_um=amplitude_um,
        contact_stiffness=1.5 / (travel_mm_per_N * contact_share),
        rig_stiffness=1.0 / (travel_mm_per_N * (1.0 - contact_share)), end_slope_rad=end_slope_rad,
        hook_power=hook_power,
    )  # fmt: skip


def drawn(count: int, least_micro_slip: float, seed: int) -> Iterator[tuple[Recipe, float, int]]:
    """Gross slip with hooks up to half as high again as the plateau; micro-slip up to 30 % of the amplitude.

    Each with a phase and a seed of its noise; the same ones in every session, as one in thousands is beyond the limits.
    """
    random = np.random.default_rng(seed)
    while count:
        recipe = recipe_of(
            friction=random.uniform(0.2, 1.1), normal_load_N=random.uniform(0.5, 20.0),
            amplitude_um=random.uniform(10.0, 200.0), micro_slip=random.uniform(least_micro_slip, 0.3),
            contact_share=random.uniform(0.01, 0.9), end_slope_rad=random.uniform(0.0, 0.2),
            hook_power=random.uniform(1.0, 6.0),
        )  # fmt: skip
        if math.tan(math.atan(recipe.friction) + recipe.end_slope_rad) < 1.5 * recipe.friction:
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


@dataclass(frozen=True)
class RealLoop:
    """A slider dragged through a spring with a dead band; forces in N, displacements in µm, K in N/µm.

    Sliding starts at the static force and, where it chatters, sticks and slips between `friction` and
    (1 − chatter_drop) of it.
    """

    friction_forward_N: float = 1.24
    friction_backward_N: float = 1.24
    stiffness_N_per_um: float = 0.157
    amplitude_um: float = 60.0
    play_um: float = 0.0
    force_offset_N: float = 0.0
    chatter_drop: float = 0.0
    static_overshoot: float = 0.0
    noise_share: float = 0.005

    def scaled(self, length: float, force: float) -> "RealLoop":
        """This loop with all lengths and forces multiplied by factors."""
        return RealLoop(
            self.friction_forward_N * force, self.friction_backward_N * force,
            self.stiffness_N_per_um * force / length, self.amplitude_um * length, self.play_um * length,
            self.force_offset_N * force, self.chatter_drop, self.static_overshoot, self.noise_share,
        )  # fmt: skip

    def _spring(self, elongation: float) -> float:
        beyond = max(abs(elongation) - 0.5 * self.play_um, 0.0)
        return self.stiffness_N_per_um * beyond * (1.0 if elongation > 0.0 else -1.0)

    def _elongation(self, force: float) -> float:
        return force / self.stiffness_N_per_um + 0.5 * self.play_um * (1.0 if force > 0.0 else -1.0)

    def sampled(self, samples: int = 512, seed: int = 0) -> tuple[Array, Array, Array]:
        """Time in cycles, displacement and force of one closed cycle under a sinusoidal drive, with noise."""
        fine, warm = 20 * samples, 10 * samples
        time = np.arange(-warm, fine) / fine
        drive = self.amplitude_um * np.sin(2.0 * np.pi * time)
        force = np.empty_like(drive)
        at, moving, started = drive[0], 1, False
        for i, x in enumerate(drive):
            direction = 1 if i and x > drive[i - 1] else -1
            if direction != moving:
                moving, started = direction, False
            limit = self.friction_forward_N if direction > 0 else self.friction_backward_N
            static = limit if started else limit * (1.0 + self.static_overshoot)
            if direction * self._spring(x - at) >= static:
                started = True
                at = x - self._elongation(direction * limit * (1.0 - self.chatter_drop))
            force[i] = self._spring(x - at)
        kept = slice(warm, None, 20)
        random = np.random.default_rng(seed)
        size = max(self.friction_forward_N, self.friction_backward_N)
        noise = self.noise_share * random.standard_normal((2, samples))
        noisy = drive[kept] + self.amplitude_um * noise[0]
        return time[kept], noisy, force[kept] + self.force_offset_N + size * noise[1]

    @property
    def chatter_events(self) -> float:
        """Slips in one cycle, about: what is slid over what the spring stretches between two of them."""
        forces = self.friction_forward_N + self.friction_backward_N
        lost = 2.0 * self.play_um + 2.0 * forces / self.stiffness_N_per_um
        return (4.0 * self.amplitude_um - lost) / (self.chatter_drop * 0.5 * forces / self.stiffness_N_per_um)
