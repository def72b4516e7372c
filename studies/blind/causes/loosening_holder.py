from dataclasses import dataclass
from math import exp

from studies.blind.causes.cause import AgeingHolder, Sizes
from studies.blind.generators.draw import Draw


@dataclass(frozen=True)
class LooseningHolder(AgeingHolder):
    """A holder that comes loose over the test, 63 % of it after `cycles`."""

    seam = "holder"
    sets = (("development", 5),)

    loosening_um_per_N: float
    cycles: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"loosening_um_per_N": d.length_um(0.8, 8.0) / d.plateau_N, "cycles": d.cycles}

    def mm_per_N(self, cycle: float) -> float:
        return 1e-3 * self.loosening_um_per_N * (1.0 - exp(-cycle / self.cycles))
