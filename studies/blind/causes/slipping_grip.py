from dataclasses import dataclass

import numpy as np

from studies.blind.generators.other_simulators.causes import OtherCause, Size, Sizes
from studies.blind.generators.other_simulators.pair import Array


@dataclass(frozen=True)
class SlippingGrip(OtherCause):
    """A grip slips under more than a share of the friction, and back once the force has turned by twice as much."""

    seam = "holder"
    sets = (("others", 5),)

    holds: float
    mm: float

    @staticmethod
    def size(d: Size) -> Sizes:
        holds = d.random.uniform(0.4, 0.75)
        return {"holds": holds, "mm": 1e-3 * d.way_um(0.02, 0.15) / (1.0 - holds)}

    def given_mm(self, force_N: Array, limit_N: float, direction: int) -> Array:
        beyond = max(float(np.abs(force_N).max()) / limit_N - self.holds, 0.0)
        travelled = np.clip(direction * force_N / limit_N - self.holds, -beyond, beyond)
        return np.asarray(self.mm * direction * np.maximum.accumulate(travelled))
