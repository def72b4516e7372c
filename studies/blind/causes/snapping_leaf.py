from dataclasses import dataclass

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Array, Signals
from studies.blind.generators.strokes import through_holder


@dataclass(frozen=True)
class SnappingLeaf(Reading):
    """A leaf of the holder was clamped under compression and buckled: it snaps over at some force either way.

    It stands at −g/2 until the force exceeds +F, at +g/2 until it falls below −F, as buckled beams do (Timoshenko &
    Gere, Theory of Elastic Stability, 2nd ed., section 7.10).
    """

    seam = "holder"
    sets = (("reserved", 9),)

    jump_um: float
    force_N: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"jump_um": d.length_um(1.0, 9.0), "force_N": d.random.uniform(0.35, 0.75) * d.plateau_N}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        def give(_place: Array, force: Array, direction: int) -> Array:
            return np.asarray(0.5 * self.jump_um * np.sign(force - direction * self.force_N))

        return through_holder(signals, give)
