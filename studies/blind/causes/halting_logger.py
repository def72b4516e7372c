from dataclasses import dataclass, replace
from math import pi

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals


@dataclass(frozen=True)
class HaltingLogger(Reading):
    """The force's logger is triggered at one end of the stroke, stores the cycle before, and repeats its last sample.

    The force stands for so long from the upper reversal on, then jumps to what it is by then.
    """

    seam = "sensor"
    sets = (("reserved", 3),)

    time_s: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"time_s": d.turning_phase(0.5, 8.0) / (2.0 * pi * d.nominal.frequency_Hz)}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        top = int(signals.displacement_um.argmax())
        since = (signals.time_s - signals.time_s[top]) % signals.period_s
        force = np.where(since < self.time_s, signals.tangential_force_N[top], signals.tangential_force_N)
        return replace(signals, tangential_force_N=force)
