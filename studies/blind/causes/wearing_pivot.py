from dataclasses import dataclass

from studies.blind.causes.cause import AgeingHolder, Sizes
from studies.blind.generators.ageing import Growth
from studies.blind.generators.draw import Draw


@dataclass(frozen=True)
class WearingPivot(AgeingHolder):
    """The pin of the holder's pivot wears evenly with the cycles, and its play grows from none."""

    seam = "holder"
    sets = (("withheld", 10),)

    gap_um: float
    cycles: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"gap_um": d.length_um(1.0, 9.0), "cycles": float(d.nominal.cycles)}

    def play_mm(self, cycle: float) -> float:
        return Growth(1e-3 * self.gap_um, self.cycles).at(cycle)
