from dataclasses import dataclass

import numpy as np

from studies.blind.generators.other_simulators.causes import OtherCause, Size, Sizes
from studies.blind.generators.other_simulators.pair import Array


@dataclass(frozen=True)
class StribeckFriction(OtherCause):
    """Friction is larger where the motion is slow, near both ends of the stroke."""

    seam = "contact"
    sets = (("others", 3),)

    rise: float

    @staticmethod
    def size(d: Size) -> Sizes:
        return {"rise": d.between(0.04, 0.4)}

    def friction_along(self, place: Array, _direction: int) -> Array:
        speed = np.sqrt(np.maximum(1.0 - place**2, 1e-3))
        return np.asarray(1.0 + self.rise * np.exp(-((speed / 0.35) ** 2)))
