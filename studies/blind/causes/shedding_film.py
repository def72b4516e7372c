from dataclasses import dataclass

from studies.blind.causes.cause import FrictionFactor, Sizes
from studies.blind.generators.draw import Draw


@dataclass(frozen=True)
class SheddingFilm(FrictionFactor):
    """A film of transferred metal builds up and is shed at once, again and again (Rigney, Wear 245 (2000) 1).

    Friction rises evenly from 1 to 1 + share over so many cycles and falls back.
    """

    seam = "contact"
    sets = (("withheld", 13),)

    share: float
    cycles: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"share": d.between(0.04, 0.3) * d.sign(0.7), "cycles": d.nominal.cycles * d.spread(0.17, 0.45)}

    def at(self, cycle: float) -> float:
        return 1.0 + self.share * ((cycle / self.cycles) % 1.0)
