from dataclasses import dataclass

from studies.blind.causes.cause import FrictionFactor, Sizes
from studies.blind.generators.ageing import Film
from studies.blind.generators.draw import Draw


@dataclass(frozen=True)
class FilmBreakthrough(FrictionFactor):
    """Wires wear through a film, of oxide or grease, under which friction is another."""

    seam = "contact"
    sets = (("unseen", 9),)

    share: float
    cycle: float
    abruptness: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {
            "share": d.between(0.05, 0.35) * d.sign(0.8),
            "cycle": d.nominal.cycles * d.spread(0.02, 0.3),
            "abruptness": d.random.uniform(3.0, 8.0),
        }

    def at(self, cycle: float) -> float:
        return Film(self.share, self.cycle, self.abruptness).at(cycle)
