from dataclasses import dataclass, replace
from math import pi

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals


@dataclass(frozen=True)
class SlewLimitedAmplifier(Reading):
    """An amplifier of the force follows no faster than its slew rate: |dQ/dt| ≤ S, so that steep flanks lean.

    Plateaus are right. Horowitz & Hill, The Art of Electronics, 3rd ed., section 4.4.
    """

    seam = "sensor"
    sets = (("withheld", 2),)

    N_per_s: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        # The force turns by 2 µP within that phase.
        return {"N_per_s": 4.0 * pi * d.nominal.frequency_Hz * d.plateau_N / d.turning_phase(2.0, 8.0)}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        force = signals.tangential_force_N
        steps = np.diff(signals.time_s, prepend=signals.time_s[-1] - signals.period_s)
        most = (self.N_per_s * steps).tolist()
        followed, at = np.empty_like(force), float(force[-1])
        for _ in range(2):  # The second cycle repeats itself.
            for i, value in enumerate(force.tolist()):
                at = min(max(value, at - most[i]), at + most[i])
                followed[i] = at
        return replace(signals, tangential_force_N=followed)
