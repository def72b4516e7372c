from dataclasses import dataclass

import numpy as np

from studies.blind.generators.other_simulators.causes import OtherCause, Size, Sizes
from studies.blind.generators.other_simulators.pair import Array


@dataclass(frozen=True)
class HardeningHolder(OtherCause):
    """A holder gives way by the cube of the force."""

    seam = "holder"
    sets = (("others", 6),)

    mm: float

    @staticmethod
    def size(d: Size) -> Sizes:
        return {"mm": 1e-3 * d.way_um(0.015, 0.12)}

    def given_mm(self, force_N: Array, limit_N: float, _direction: int) -> Array:
        return np.asarray(self.mm * (force_N / limit_N) ** 3)
