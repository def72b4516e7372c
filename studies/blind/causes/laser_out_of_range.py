from dataclasses import dataclass, replace

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals


@dataclass(frozen=True)
class LaserOutOfRange(Reading):
    """The laser was mounted too near or too far: it reads no further than its range, which ends within the stroke.

    min(δ, l) where the limit l is positive, max(δ, l) where it is negative.
    """

    seam = "sensor"
    sets = (("reserved", 2),)

    limit_um: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"limit_um": d.nominal.amplitude_um * (1.0 - d.between(0.012, 0.12)) * d.sign()}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        least, most = (-np.inf, self.limit_um) if self.limit_um > 0.0 else (self.limit_um, np.inf)
        return replace(signals, displacement_um=np.clip(signals.displacement_um, least, most))
