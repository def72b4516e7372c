from dataclasses import dataclass

import numpy as np

from studies.blind.generators.other_simulators.causes import OtherCause, Size, Sizes
from studies.blind.generators.other_simulators.pair import Array


@dataclass(frozen=True)
class BowedGuide(OtherCause):
    """The guide is bowed, so that the load changes towards both ends of the stroke."""

    seam = "loading"
    sets = (("others", 8),)

    share: float

    @staticmethod
    def size(d: Size) -> Sizes:
        return {"share": d.either(0.04, 0.35)}

    def load_along(self, place: Array, _direction: int) -> Array:
        return np.asarray(1.0 + self.share * (place**2 - 0.5))
