from dataclasses import dataclass
from math import pi, sin

from studies.blind.causes.cause import LoadFactor, Sizes
from studies.blind.generators.draw import Draw


@dataclass(frozen=True)
class SwingingLoad(LoadFactor):
    """The frame grows and shrinks with the temperature of the room against the loading spring.

    1 + share sin(2π n/n_T + φ), evenly in time as temperatures of rooms swing.
    """

    seam = "loading"
    sets = (("withheld", 15),)

    share: float
    cycles: float
    phase_rad: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {
            "share": d.between(0.02, 0.18),
            "cycles": d.nominal.cycles * d.spread(0.2, 0.7),
            "phase_rad": d.random.uniform(-pi, pi),
        }

    def at(self, cycle: float) -> float:
        return 1.0 + self.share * sin(2.0 * pi * cycle / self.cycles + self.phase_rad)
