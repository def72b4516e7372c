from dataclasses import dataclass, replace

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals, place_in_stroke


@dataclass(frozen=True)
class ThinningGrease(Reading):
    """Grease that drawing left between the wires drags by its viscosity and is squeezed out over the cycles.

    F v/v_max exp(−n/n_c), Newton's law at a film of constant thickness; v_max that of a sine of the same amplitude.
    """

    seam = "contact"
    sets = (("withheld", 7),)

    force_N: float
    cycles: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"force_N": d.between(0.03, 0.3) * d.plateau_N, "cycles": d.nominal.cycles * d.spread(0.05, 0.5)}

    def read(self, signals: Signals, cycle: float) -> Signals:
        _, half = place_in_stroke(signals)
        time, period = signals.time_s, signals.period_s
        passed = np.roll(signals.displacement_um, -1) - np.roll(signals.displacement_um, 1)
        taken = (np.roll(time, -1) - np.roll(time, 1)) % period
        speed = passed / taken / (2.0 * np.pi * half / period)
        drag = self.force_N * np.exp(-cycle / self.cycles) * speed
        return replace(signals, tangential_force_N=np.asarray(signals.tangential_force_N + drag))
