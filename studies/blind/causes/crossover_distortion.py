from dataclasses import dataclass, replace

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals


@dataclass(frozen=True)
class CrossoverDistortion(Reading):
    """The output stage of the force amplifier has lost its bias: nothing comes out within a band about zero.

    sign(Q) max(|Q| − b, 0); Horowitz & Hill, The Art of Electronics, 3rd ed., section 2.4.
    """

    seam = "sensor"
    sets = (("withheld", 3),)

    band_N: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"band_N": d.between(0.02, 0.2) * d.plateau_N}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        force = signals.tangential_force_N
        return replace(signals, tangential_force_N=force - np.clip(force, -self.band_N, self.band_N))
