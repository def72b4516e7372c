from dataclasses import dataclass, replace

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals, place_in_stroke


@dataclass(frozen=True)
class HookedFriction(Reading):
    """Each wire runs up the far rim of the other's scar, so that friction rises towards the end of either stroke.

    Mulvihill et al., Wear 271 (2011) 1071, found such hooks in gross slip: Q (1 + h q (δ/A)³), q the force over its
    largest, at the cycle's amplitude A.
    """

    seam = "contact"
    sets = (("unseen", 8),)

    rise: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"rise": d.between(0.04, 0.4) * d.sign(0.8)}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        place, _ = place_in_stroke(signals)
        force = signals.tangential_force_N
        mobilised = force / max(float(np.abs(force).max()), 1e-12)
        return replace(signals, tangential_force_N=force * (1.0 + self.rise * mobilised * place**3))
