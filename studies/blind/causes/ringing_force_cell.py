from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Array, Signals, filtered


@dataclass(frozen=True)
class RingingForceCell(Reading):
    """A heavy holder on a soft force cell rings whenever friction turns: an oscillator of one degree of freedom.

    1/(1 − r² + 2iζr) with r the frequency over the natural one (den Hartog, Mechanical Vibrations, section 2.9).
    """

    seam = "sensor"
    sets = (("unseen", 1),)

    natural_frequency_Hz: float
    damping: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"natural_frequency_Hz": d.nominal.frequency_Hz / d.between(0.03, 0.12), "damping": d.spread(0.03, 0.15)}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        def passed(frequency_Hz: Array) -> NDArray[np.complex128]:
            ratio = frequency_Hz / self.natural_frequency_Hz
            return np.asarray(1.0 / (1.0 - ratio**2 + 2j * self.damping * ratio))

        return replace(signals, tangential_force_N=filtered(signals, signals.tangential_force_N, passed))
