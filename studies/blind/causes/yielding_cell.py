from dataclasses import dataclass

import numpy as np

from studies.blind.generators.other_simulators.causes import OtherCause, Size, Sizes
from studies.blind.generators.other_simulators.pair import Array


@dataclass(frozen=True)
class YieldingCell(OtherCause):
    """The force cell yields a little under large forces, and reads less of them: Q (1 − loss min((Q/µP)², 2))."""

    seam = "sensor"
    sets = (("others", 1),)

    loss: float

    @staticmethod
    def size(d: Size) -> Sizes:
        return {"loss": d.between(0.02, 0.2)}

    def read_N(self, force_N: Array, limit_N: float, _cycle: float) -> Array:
        return np.asarray(force_N * (1.0 - self.loss * np.minimum((force_N / limit_N) ** 2, 2.0)))
