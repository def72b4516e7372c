from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Array, Signals, filtered


@dataclass(frozen=True)
class CreepingJoint(Reading):
    """A glued joint between wire and sensor target gives way late: a Kelvin–Voigt solid under the tangential force."""

    seam = "sensor"
    sets = (("unseen", 4),)

    um_per_N: float
    time_s: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"um_per_N": d.length_um(0.6, 6.0) / d.plateau_N, "time_s": d.spread(0.06, 0.4) / d.nominal.frequency_Hz}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        def passed(frequency_Hz: Array) -> NDArray[np.complex128]:
            return np.asarray(1.0 / (1.0 + 2j * np.pi * frequency_Hz * self.time_s))

        given = self.um_per_N * filtered(signals, signals.tangential_force_N, passed)
        return replace(signals, displacement_um=signals.displacement_um + given)
