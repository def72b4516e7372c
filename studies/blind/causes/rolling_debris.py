from dataclasses import dataclass, replace

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals, place_in_stroke
from studies.blind.generators.strokes import since_reversal


@dataclass(frozen=True)
class RollingDebris(Reading):
    """Rolls of debris between the wires roll back after each reversal, at less friction, until they jam.

    Cylindrical debris lowers friction while it rolls (Zanoria et al., Tribology Transactions 38 (1995) 721). The share
    of rolls that still roll after a way d is 1/(1 + (d/l)^k), with l a share of the stroke and k = 10.
    """

    seam = "contact"
    sets = (("reserved", 5),)

    loss: float
    over: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"loss": d.between(0.05, 0.4), "over": d.random.uniform(0.25, 0.55)}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        passed, direction = since_reversal(signals)
        _, half = place_in_stroke(signals)
        force = signals.tangential_force_N
        rolling = 1.0 / (1.0 + (passed / (2.0 * half * self.over)) ** 10.0)
        mobilised = np.maximum(direction * force, 0.0) / max(float(np.abs(force).max()), 1e-12)
        return replace(signals, tangential_force_N=np.asarray(force * (1.0 - self.loss * rolling * mobilised)))
