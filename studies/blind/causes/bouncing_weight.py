from dataclasses import dataclass
from math import pi

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals, loaded


@dataclass(frozen=True)
class BouncingWeight(Reading):
    """Dead weights on a springy lever bounce as the guide shakes them twice a cycle, with the phase of a resonance."""

    seam = "loading"
    sets = (("unseen", 7),)

    share: float
    phase_rad: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"share": d.between(0.04, 0.35), "phase_rad": d.random.uniform(0.25 * pi, 0.75 * pi) * d.sign()}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        turn = 4.0 * np.pi * signals.time_s / signals.period_s
        return loaded(signals, 1.0 + self.share * np.cos(turn - self.phase_rad))
