from dataclasses import dataclass
from math import log, pi, sin

from studies.blind.causes.cause import FrictionFactor, Sizes
from studies.blind.generators.draw import Draw


@dataclass(frozen=True)
class BreathingFriction(FrictionFactor):
    """Friction comes and goes over the test, as debris gathers and leaves: a wave over the logarithm of the cycles."""

    seam = "contact"
    sets = (("sealed", 8),)

    share: float
    folds: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"share": d.between(0.02, 0.15), "folds": d.random.uniform(1.2, 3.5)}

    def at(self, cycle: float) -> float:
        return 1.0 + self.share * sin(2.0 * pi * log(max(cycle, 1.0)) / self.folds)
