from dataclasses import dataclass

import numpy as np

from studies.blind.generators.other_simulators.causes import OtherCause, Size, Sizes
from studies.blind.generators.other_simulators.pair import Array


@dataclass(frozen=True)
class JammedEnd(OtherCause):
    """Debris jams before one end of the stroke: friction rises there, on the way to it."""

    seam = "contact"
    sets = (("others", 4),)

    rise: float

    @staticmethod
    def size(d: Size) -> Sizes:
        return {"rise": d.between(0.05, 0.5)}

    def friction_along(self, place: Array, direction: int) -> Array:
        return np.asarray(1.0 + self.rise * np.clip((place - 0.55) / 0.3, 0.0, 1.0) * (direction > 0))
