from dataclasses import dataclass, replace

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals, place_in_stroke


@dataclass(frozen=True)
class HystereticDisplacement(Reading):
    """A piezo stage or an inductive core has a hysteresis of its own: it lags on both branches, most in mid-stroke.

    Rayleigh's loop, δ ∓ share (A² − δ²)/A (Rayleigh, Philosophical Magazine 23 (1887) 225), at the cycle's amplitude A.
    """

    seam = "sensor"
    sets = (("unseen", 2),)

    share: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"share": d.between(0.03, 0.25)}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        place, half = place_in_stroke(signals)
        direction = np.sign(np.roll(place, -1) - np.roll(place, 1))
        lag = self.share * half * np.maximum(1.0 - place**2, 0.0) * direction
        return replace(signals, displacement_um=signals.displacement_um - lag)
