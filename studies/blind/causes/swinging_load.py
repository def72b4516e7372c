from dataclasses import dataclass
from math import pi, sin

import numpy as np

from studies.blind.causes.cause import LoadFactor, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.other_simulators.causes import OtherCause, Size


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


@dataclass(frozen=True)
class SwingingLoadOfOthers(OtherCause):
    """In tests by others: so many turns a cycle, from the start on."""

    seam = "loading"
    sets = (("others", 9),)

    share: float
    turns: float

    @staticmethod
    def size(d: Size) -> Sizes:
        return {"share": d.between(0.02, 0.15), "turns": d.random.uniform(1.5, 5.0) / d.test.cycles}

    def load(self, cycle: float) -> float:
        return float(1.0 + self.share * np.sin(2.0 * np.pi * self.turns * cycle))
