"""Noise of a sensor's samples: Gaussian, white or with a memory of one sample."""

from dataclasses import dataclass
from math import isfinite, sqrt

import numpy as np

from wirewear.errors import SensorError
from wirewear.sensor.signals import Array


@dataclass(frozen=True)
class SensorNoise:
    """Standard deviations of one sample of each channel, and how much of it the next sample remembers.

    `correlation` ρ makes the noise a stationary autoregressive process of order one, e' = ρ e + √(1−ρ²) σ w with
    white w (Box & Jenkins, Time Series Analysis, section 3.2); 0 is white noise. Each loop draws its own.

    Raises:
        SensorError: a deviation that is negative, or a correlation outside [0, 1).
    """

    displacement_um: float = 0.0
    tangential_force_N: float = 0.0
    normal_force_N: float = 0.0
    correlation: float = 0.0

    def __post_init__(self) -> None:
        for name in ("displacement_um", "tangential_force_N", "normal_force_N"):
            value = getattr(self, name)
            if not (isfinite(value) and value >= 0.0):
                raise SensorError(f"the noise of {name} is {value}, but must be a number that is not negative")
        if not 0.0 <= self.correlation < 1.0:
            raise SensorError(f"the noise's correlation is {self.correlation}, but must be at least 0 and below 1")

    def on(self, values: Array, deviation: float, random: np.random.Generator) -> Array:
        """The samples (n,) with noise of that standard deviation; without any, the samples themselves."""
        if deviation == 0.0:
            return values
        white = random.standard_normal(values.size)
        if self.correlation == 0.0:
            return values + deviation * white

        from scipy.signal import lfilter

        # The first sample already has the process's full deviation.
        white[1:] *= sqrt(1.0 - self.correlation**2)
        return np.asarray(values + deviation * lfilter([1.0], [1.0, -self.correlation], white))
