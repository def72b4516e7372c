from dataclasses import dataclass, replace

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.ageing import Growth
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals, beyond, place_in_stroke


@dataclass(frozen=True)
class DebrisRidge(Reading):
    """Debris is swept to one end of the stroke, where a ridge grows that the wire runs against and is pushed back by.

    It bears R max(s δ/A − b, 0)/(1 − b) against the motion to its end s = ±1, elastically; R grows with the worn
    volume, hence evenly with the cycles, to `force_N` at `cycles`. A negative force puts it at the other end.
    """

    seam = "contact"
    sets = (("withheld", 6),)

    force_N: float
    begins: float
    cycles: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {
            "force_N": d.between(0.01, 0.1) * d.plateau_N * d.sign(),
            "begins": d.random.uniform(0.3, 0.7),
            "cycles": d.nominal.cycles * d.spread(0.2, 1.0),
        }

    def read(self, signals: Signals, cycle: float) -> Signals:
        place, _ = place_in_stroke(signals)
        push = Growth(self.force_N, self.cycles).at(cycle) * beyond(place, self.force_N, self.begins)
        return replace(signals, tangential_force_N=np.asarray(signals.tangential_force_N + push))
