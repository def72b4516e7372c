from dataclasses import dataclass, replace

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals, place_in_stroke
from studies.blind.generators.strokes import since_reversal


@dataclass(frozen=True)
class StickSlip(Reading):
    """The wires stick and slip along each stroke: the force builds up evenly and drops at once, so many times.

    Bowden & Leben, Proc. R. Soc. A 169 (1939) 371. The first stick of a stroke is its flank; each slip takes a share.
    """

    seam = "contact"
    sets = (("reserved", 4),)

    share: float
    per_stroke: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"share": d.between(0.06, 0.5), "per_stroke": float(d.random.integers(4, 9))}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        passed, _ = since_reversal(signals)
        _, half = place_in_stroke(signals)
        sticks = self.per_stroke * passed / (2.0 * half)
        lost = np.where(sticks < 1.0, 0.0, self.share * (1.0 - sticks % 1.0))
        return replace(signals, tangential_force_N=np.asarray(signals.tangential_force_N * (1.0 - lost)))
