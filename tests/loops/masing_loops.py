"""Loops of contacts that follow Masing's rule behind a rig with play, and what a measurement does to them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import Array


@dataclass(frozen=True)
class MasingLoop:
    """A contact that yields by L(1 − (1 − y/u)ⁿ), in series with a spring and a play; lengths in µm, forces in N.

    n = 1 is Coulomb friction behind a spring, 1.5 a Mindlin contact of spheres, 2 Iwan's of evenly spread limits. The
    scar's walls add wall·L(y/ya)³, whichever way the contact moves. It slides where ya > u.
    Source: Masing, Proc. 2nd Int. Congress of Applied Mechanics (1926) 332: branches are the first loading, twice as
    large.
    """

    friction: float
    normal_force_N: float
    contact_um: float  # ya
    yield_um: float  # u
    power: float  # n
    rig_N_per_um: float
    play_um: float = 0.0
    wall: float = 0.0

    @property
    def limit_N(self) -> float:
        return self.friction * self.normal_force_N

    @property
    def slides(self) -> bool:
        return self.contact_um > self.yield_um

    def _first_loading(self, share: Array) -> Array:
        return np.asarray(self.limit_N * (1.0 - (1.0 - np.minimum(share, 1.0)) ** self.power))

    @property
    def _turning_N(self) -> float:
        return float(self._first_loading(np.array(self.contact_um / self.yield_um)))

    @cached_property
    def branch(self) -> tuple[Array, Array]:
        """Displacement and force of the forward branch (n,)."""
        y = np.concatenate([self.contact_um * np.linspace(-1.0, 1.0, 4001), self._knees()])
        y = np.sort(y)
        force = 2.0 * self._first_loading(0.5 * (y + self.contact_um) / self.yield_um) - self._turning_N
        force = force + self.wall * self.limit_N * (y / self.contact_um) ** 3
        zero = float(np.interp(0.0, force, y))
        at = np.searchsorted(y, zero)
        y, force = np.insert(y, at, [zero, zero]), np.insert(force, at, [0.0, 0.0])
        side = np.where(np.arange(y.size) <= at, -0.5, 0.5)
        return y + force / self.rig_N_per_um + side * self.play_um, force

    def _knees(self) -> Array:
        """Contact displacements about the onset of sliding."""
        onset = 2.0 * self.yield_um - self.contact_um
        return np.array([onset]) if onset < self.contact_um else np.empty(0)

    @property
    def amplitude_um(self) -> float:
        return float(self.branch[0][-1])

    @property
    def largest_N(self) -> float:
        return float(self.branch[1].max())

    @property
    def energy_mJ(self) -> float:
        """∮Q dy: neither spring nor play nor walls take any of it."""
        y, u, n = self.contact_um, self.yield_um, self.power
        if y >= u:
            return 4e-3 * self.limit_N * (y - 2.0 * u / (n + 1.0))
        # Twice ∫ of the branch: its rise 2L(1 − (1 − t)ⁿ) over t = (y + ya)/2u, less the turning force.
        t = y / u
        rise = 2.0 * self.limit_N * 2.0 * u * (t - (1.0 - (1.0 - t) ** (n + 1.0)) / (n + 1.0))
        return float(2e-3 * (rise - 2.0 * y * self._turning_N))

    @property
    def slip_um(self) -> float:
        """Half the width at zero force of the loop without play."""
        displacement, force = self.branch
        return -float(np.mean(displacement[force == 0.0]))

    @property
    def stiffness_N_per_um(self) -> float:
        """Slope of the line over half of the travel from the reversal to sliding, of the loop without play."""
        displacement, force = self.branch
        travel = displacement - np.where(np.arange(force.size) > np.argmax(force >= 0.0), self.play_um, 0.0)
        travel = travel - travel[0]
        end = 2.0 * self.yield_um + (force[-1] - force[0]) / self.rig_N_per_um
        even = np.linspace(0.0, 0.5 * min(end, float(travel[-1])), 2001)
        return float(np.polyfit(even, np.interp(even, travel, force), 1)[0])

    def sampled(self, cycles: Array) -> tuple[Array, Array]:
        """Displacement and force at times (n,) in cycles of a sinusoidal drive."""
        displacement = self.amplitude_um * np.sin(2.0 * np.pi * cycles)
        way = np.where(np.cos(2.0 * np.pi * cycles) >= 0.0, 1.0, -1.0)
        return displacement, way * np.interp(way * displacement, *self.branch)


@dataclass(frozen=True)
class Disturbance:
    """What a measurement does to a loop; shares are of the stroke's half and of the sliding force."""

    samples: int = 200
    cycles: float = 1.0
    phase: float = 0.0
    noise: float = 0.0
    lag_samples: float = 0.0
    drift: float = 0.0
    ringing: float = 0.0
    ring_period_samples: float = 2.0
    clip: float | None = None
    clip_one_side: bool = False
    sign: float = 1.0
    force_offset: float = 0.0
    displacement_offset: float = 0.0
    seed: int = 0

    def of(self, loop: MasingLoop) -> tuple[Array, Array, Array]:
        """Times in cycles, displacement and force (n,)."""
        random = np.random.default_rng(self.seed)
        time = np.arange(round(self.samples * self.cycles)) / self.samples
        at = time + self.phase
        displacement = loop.sampled(at)[0]
        force = loop.sampled(at - self.lag_samples / self.samples)[1]
        since = (at - 0.25) % 0.5
        ring = np.cos(2.0 * np.pi * since * self.samples / self.ring_period_samples) * np.exp(-since / 0.06)
        way = np.where(np.cos(2.0 * np.pi * at) >= 0.0, 1.0, -1.0)
        force = force + self.ringing * loop.limit_N * ring * way
        displacement = displacement + self.drift * loop.amplitude_um * time
        displacement = displacement + self.noise * loop.amplitude_um * random.standard_normal(time.size)
        force = force + self.noise * loop.limit_N * random.standard_normal(time.size)
        force = self.sign * force + self.force_offset * loop.limit_N
        if self.clip is not None:
            high = self.clip * loop.largest_N
            force = np.clip(force, -np.inf if self.clip_one_side else -high, high)
        return time, displacement + self.displacement_offset * loop.amplitude_um, force
