from dataclasses import dataclass, replace
from math import pi

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals


@dataclass(frozen=True)
class CyclicEncoder(Reading):
    """The reading head of an encoder is badly set: its error comes again with every line of the scale.

    δ + e (sin(2π δ/p + φ) − sin φ); shifted quadrature signals err so (Heydemann, Applied Optics 20 (1981) 3382).
    """

    seam = "sensor"
    sets = (("reserved", 0),)

    error_um: float
    pitch_um: float
    phase_rad: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        # Errors beyond a sixth of a line, 1/2π, would make the reading run backwards.
        pitch = d.spread(16.0, 40.0)
        return {"error_um": pitch * d.between(0.02, 0.13), "pitch_um": pitch, "phase_rad": d.random.uniform(-pi, pi)}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        turn = 2.0 * np.pi * signals.displacement_um / self.pitch_um + self.phase_rad
        error = self.error_um * (np.sin(turn) - np.sin(self.phase_rad))
        return replace(signals, displacement_um=np.asarray(signals.displacement_um + error))
