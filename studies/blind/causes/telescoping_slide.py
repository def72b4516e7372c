from dataclasses import dataclass

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Array, Signals, place_in_stroke
from studies.blind.generators.strokes import through_holder


@dataclass(frozen=True)
class TelescopingSlide(Reading):
    """The holder's slide sticks further out of its guide the further the stroke has come, and gives way more there.

    c Q (1 ± δ/A)/2: nothing at one end of the stroke, c Q at the other; a negative compliance puts it at the low end.
    """

    seam = "holder"
    sets = (("reserved", 10),)

    um_per_N: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"um_per_N": d.length_um(0.8, 8.0) / d.plateau_N * d.sign()}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        _, half = place_in_stroke(signals)
        middle = float(signals.displacement_um.max()) - half

        def give(displacement: Array, force: Array, _direction: int) -> Array:
            out = 0.5 * (1.0 + np.sign(self.um_per_N) * (displacement - middle) / half)
            return np.asarray(abs(self.um_per_N) * out * force)

        return through_holder(signals, give)
