from dataclasses import dataclass

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals, loaded
from wirewear.base.course import Course


@dataclass(frozen=True)
class FadingSupply(Reading):
    """The voltage that feeds both bridges of the force cell fades, so that both forces read ever less, or more."""

    seam = "sensor"
    sets = (("unseen", 3),)

    change: float
    cycles: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"change": d.between(0.02, 0.2) * d.sign(0.3), "cycles": d.cycles}

    def read(self, signals: Signals, cycle: float) -> Signals:
        gain = Course(1.0, 1.0 + self.change, self.cycles)
        return loaded(signals, np.full(signals.time_s.size, gain.at(cycle)))
