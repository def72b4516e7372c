from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Array, Signals, filtered


@dataclass(frozen=True)
class LeakingCharge(Reading):
    """A piezo-electric force cell's charge leaks through damp cables, so that no force is held: plateaus sag to zero.

    A high pass of first order, iωτ/(1 + iωτ) (Bendat & Piersol, Random Data, 4th ed., section 2.3).
    """

    seam = "sensor"
    sets = (("unseen", 0),)

    time_s: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"time_s": 0.5 / (d.nominal.frequency_Hz * d.between(0.07, 0.6))}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        def passed(frequency_Hz: Array) -> NDArray[np.complex128]:
            turn = 2j * np.pi * frequency_Hz * self.time_s
            return np.asarray(turn / (1.0 + turn))

        return replace(signals, tangential_force_N=filtered(signals, signals.tangential_force_N, passed))
