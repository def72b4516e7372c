from dataclasses import dataclass

import numpy as np

from studies.blind.generators.other_simulators.causes import OtherCause, Size, Sizes
from studies.blind.generators.other_simulators.pair import Array


@dataclass(frozen=True)
class LateLoad(OtherCause):
    """The load's lever drags, so that the load is more one way than the other, most in mid-stroke."""

    seam = "loading"
    sets = (("others", 7),)

    share: float

    @staticmethod
    def size(d: Size) -> Sizes:
        return {"share": d.either(0.02, 0.2)}

    def load_along(self, place: Array, direction: int) -> Array:
        return np.asarray(1.0 + self.share * direction * np.sqrt(np.maximum(1.0 - place**2, 0.0)))
