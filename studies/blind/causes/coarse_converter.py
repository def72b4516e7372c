from dataclasses import dataclass, replace

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals


@dataclass(frozen=True)
class CoarseConverter(Reading):
    """The range of the force's converter is set far too wide, so that the force is read in coarse steps.

    s round(Q/s); its error is spread evenly over ±s/2 (Bennett, Bell System Technical Journal 27 (1948) 446).
    """

    seam = "sensor"
    sets = (("reserved", 1),)

    step_N: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"step_N": d.between(0.06, 0.5) * d.plateau_N}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        steps = np.round(signals.tangential_force_N / self.step_N)
        return replace(signals, tangential_force_N=np.asarray(self.step_N * steps))
