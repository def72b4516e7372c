from dataclasses import dataclass

from studies.blind.causes.cause import Sizes, WearFactor
from studies.blind.generators.ageing import Film
from studies.blind.generators.draw import Draw


@dataclass(frozen=True)
class IncubatedWear(WearFactor):
    """A hard coat or oxide wears hardly until it is broken, and the wires as stated afterwards."""

    seam = "wear"
    sets = (("withheld", 16),)

    share: float
    cycle: float
    abruptness: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {
            "share": d.random.uniform(0.85, 0.98),
            "cycle": d.nominal.cycles * d.between(0.06, 0.5),
            "abruptness": d.random.uniform(4.0, 10.0),
        }

    def at(self, cycle: float) -> float:
        return Film(self.share, self.cycle, self.abruptness).at(cycle)
