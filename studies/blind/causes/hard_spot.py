from dataclasses import dataclass, replace

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals, place_in_stroke


@dataclass(frozen=True)
class HardSpot(Reading):
    """An inclusion or a lump of debris pressed into the track: friction differs where the wires pass over it.

    Q (1 + r exp(−((δ/A − p)/w)²)), at the same place p on the way there and back.
    """

    seam = "contact"
    sets = (("withheld", 5),)

    rise: float
    place: float
    width: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {
            "rise": d.between(0.04, 0.35) * d.sign(0.8),
            "place": d.random.uniform(-0.5, 0.5),
            "width": d.random.uniform(0.08, 0.2),
        }

    def read(self, signals: Signals, _cycle: float) -> Signals:
        place, _ = place_in_stroke(signals)
        factor = 1.0 + self.rise * np.exp(-(((place - self.place) / self.width) ** 2))
        return replace(signals, tangential_force_N=np.asarray(signals.tangential_force_N * factor))
