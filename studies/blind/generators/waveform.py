"""How rigs move over a cycle, the same for all forward models."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SAMPLES = 1024  #: Even times of a cycle, before the record's sampling.


@dataclass(frozen=True)
class Waveform:
    """An eccentric's sine with harmonics."""

    second_harmonic: float = 0.0
    third_harmonic: float = 0.0

    def shape(self) -> Array:
        """The motion over a cycle from mid-stroke, between −1 and 1 (SAMPLES,)."""
        phase = 2.0 * np.pi * np.arange(SAMPLES) / SAMPLES
        shape = np.sin(phase) + self.second_harmonic * np.sin(2.0 * phase) + self.third_harmonic * np.sin(3.0 * phase)
        middle, half = 0.5 * (shape.max() + shape.min()), 0.5 * (shape.max() - shape.min())
        return np.asarray((shape - middle) / half)
