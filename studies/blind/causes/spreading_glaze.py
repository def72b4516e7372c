from dataclasses import dataclass, replace

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.ageing import Growth
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals, place_in_stroke


@dataclass(frozen=True)
class SpreadingGlaze(Reading):
    """Oxide is pressed to a glaze at one end of the track, which spreads over it and rubs otherwise than the rest.

    Its edge comes from one end to the other as √n, the parabolic growth of oxides (Stott, Tribology Int. 31 (1998) 61),
    and is there at `cycles`. A negative share rubs more; `end` is the end where it begins, ±1.
    """

    seam = "contact"
    sets = (("reserved", 6),)

    share: float
    end: float
    cycles: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {
            "share": d.between(0.008, 0.1) * d.sign(0.7),
            "end": d.sign(),
            "cycles": d.nominal.cycles * d.spread(0.4, 2.0),
        }

    def read(self, signals: Signals, cycle: float) -> Signals:
        place, _ = place_in_stroke(signals)
        edge = 0.06  # Of the glaze, over half of the stroke.
        spread = Growth(2.0 + 4.0 * edge, self.cycles, 0.5).at(cycle) - 2.0 * edge
        glazed = 0.5 * (1.0 - np.tanh((1.0 - self.end * place - spread) / edge))
        return replace(signals, tangential_force_N=np.asarray(signals.tangential_force_N * (1.0 - self.share * glazed)))
