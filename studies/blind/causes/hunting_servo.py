from dataclasses import dataclass

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals, loaded


@dataclass(frozen=True)
class HuntingServo(Reading):
    """The controller of the load is set too sharp and hunts about it, in no time with the stroke.

    P (1 + s sin 2πft), t from the start of the test on: a limit cycle (Franklin, Powell & Emami-Naeini, Feedback
    Control of Dynamic Systems, chapter 9).
    """

    seam = "loading"
    sets = (("reserved", 7),)

    share: float
    frequency_Hz: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {
            "share": d.between(0.008, 0.1),
            "frequency_Hz": d.nominal.frequency_Hz * (d.random.integers(2, 7) + d.random.uniform(0.2, 0.8)),
        }

    def read(self, signals: Signals, cycle: float) -> Signals:
        time = cycle * signals.period_s + signals.time_s
        return loaded(signals, np.asarray(1.0 + self.share * np.sin(2.0 * np.pi * self.frequency_Hz * time)))
