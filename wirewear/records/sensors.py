"""What a rig's sensors make of the true motion and forces: the seam at which models of sensors are put in."""

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from wirewear.records.tables import Noise
from wirewear.records.values import Array, MeasuredLoop


class Sensors(Protocol):
    """Anything that turns a true loop into the readings of it."""

    @property
    def noise(self) -> Noise:
        """Standard deviations of one sample, as the owner of such sensors would state them."""
        ...

    def read(self, loop: MeasuredLoop, random: np.random.Generator) -> MeasuredLoop:
        """The readings of a loop whose channels hold true values."""
        ...


@dataclass(frozen=True)
class GainAndNoise:
    """Sensors with a gain and white Gaussian noise on each channel; as they stand, they read the truth."""

    displacement_gain: float = 1.0
    tangential_force_gain: float = 1.0
    normal_force_gain: float = 1.0
    displacement_noise_um: float = 0.0
    tangential_force_noise_N: float = 0.0
    normal_force_noise_N: float = 0.0

    @property
    def noise(self) -> Noise:
        """The noise of each channel."""
        return Noise(
            displacement_um=self.displacement_noise_um,
            tangential_force_N=self.tangential_force_noise_N,
            normal_force_N=self.normal_force_noise_N,
        )

    def read(self, loop: MeasuredLoop, random: np.random.Generator) -> MeasuredLoop:
        """Gain times the true value, plus noise."""

        def channel(true: Array, gain: float, noise: float) -> Array:
            return gain * true + noise * random.standard_normal(true.size)

        normal = loop.normal_force_N
        return replace(
            loop,
            displacement_um=channel(loop.displacement_um, self.displacement_gain, self.displacement_noise_um),
            tangential_force_N=channel(
                loop.tangential_force_N, self.tangential_force_gain, self.tangential_force_noise_N
            ),
            normal_force_N=None
            if normal is None
            else channel(normal, self.normal_force_gain, self.normal_force_noise_N),
        )
