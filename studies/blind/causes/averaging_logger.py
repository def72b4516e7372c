from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Array, Signals, filtered


@dataclass(frozen=True)
class AveragingLogger(Reading):
    """A logger averages every channel over a window about each sample, so that corners are round on both sides.

    The transfer function of an average over a time w is sin(π f w)/(π f w), without a lag.
    """

    seam = "sensor"
    sets = (("withheld", 4),)

    time_s: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"time_s": d.between(0.03, 0.16) / d.nominal.frequency_Hz}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        def passed(frequency_Hz: Array) -> NDArray[np.complex128]:
            return np.asarray(np.sinc(frequency_Hz * self.time_s), dtype=np.complex128)

        return replace(
            signals,
            displacement_um=filtered(signals, signals.displacement_um, passed),
            tangential_force_N=filtered(signals, signals.tangential_force_N, passed),
            normal_force_N=filtered(signals, signals.normal_force_N, passed),
        )
