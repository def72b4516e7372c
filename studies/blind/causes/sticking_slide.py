from dataclasses import dataclass
from math import sqrt

from studies.blind.causes.cause import LoadFactor, Sizes
from studies.blind.generators.draw import Draw


@dataclass(frozen=True)
class StickingSlide(LoadFactor):
    """The upright slide of the load sticks while the wires sink away from it, and slips after them now and then.

    1 − loss (√(n/n_1) mod 1): worn depths of crossed wires grow as √n, h²/D with V = πDh⁴/2D.
    """

    seam = "loading"
    sets = (("reserved", 12),)

    loss: float
    cycles: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"loss": d.between(0.02, 0.22), "cycles": d.nominal.cycles / d.random.uniform(3.3, 6.5) ** 2}

    def at(self, cycle: float) -> float:
        return 1.0 - self.loss * (sqrt(max(cycle, 0.0) / self.cycles) % 1.0)
