"""Loops as rigs give them: free play, stick-slip, static peaks, an offset, friction unequal by direction."""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array


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
        """The same loop of a larger or smaller rig."""
        return RealLoop(
            self.friction_forward_N * force,
            self.friction_backward_N * force,
            self.stiffness_N_per_um * force / length,
            self.amplitude_um * length,
            self.play_um * length,
            self.force_offset_N * force,
            self.chatter_drop,
            self.static_overshoot,
            self.noise_share,
        )

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
        each = self.chatter_drop * 0.5 * forces / self.stiffness_N_per_um
        return (4.0 * self.amplitude_um - lost) / each
