from dataclasses import dataclass

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals, loaded


@dataclass(frozen=True)
class RattlingWeight(Reading):
    """The dead weight hangs loose and rattles after the knock of each reversal until its swing has died away.

    P (1 + s exp(−t/τ) sin(2π f t)), t since the last reversal: the answer of a damped oscillator to a blow (den
    Hartog, Mechanical Vibrations, chapter 2).
    """

    seam = "loading"
    sets = (("withheld", 8),)

    share: float
    frequency_Hz: float
    time_s: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {
            "share": d.between(0.08, 0.6) * d.sign(),
            "frequency_Hz": d.nominal.frequency_Hz * d.spread(4.0, 9.0),
            "time_s": d.random.uniform(0.06, 0.14) / d.nominal.frequency_Hz,
        }

    def read(self, signals: Signals, _cycle: float) -> Signals:
        ends = (int(signals.displacement_um.argmax()), int(signals.displacement_um.argmin()))
        since = np.min([(signals.time_s - signals.time_s[end]) % signals.period_s for end in ends], axis=0)
        swing = np.exp(-since / self.time_s) * np.sin(2.0 * np.pi * self.frequency_Hz * since)
        return loaded(signals, np.asarray(1.0 + self.share * swing))
