from dataclasses import dataclass

from studies.blind.causes.cause import AgeingHolder, Sizes
from studies.blind.generators.ageing import Growth
from studies.blind.generators.draw import Draw


@dataclass(frozen=True)
class CrackingFlexure(AgeingHolder):
    """A fatigue crack grows through a leaf of the holder, which gives way ever faster: c (n/n_e)^p in series."""

    seam = "holder"
    sets = (("withheld", 9),)

    um_per_N: float
    cycles: float
    power: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {
            "um_per_N": d.length_um(0.45, 3.5) / d.plateau_N,
            "cycles": float(d.nominal.cycles),
            "power": d.random.uniform(2.0, 5.0),
        }

    def mm_per_N(self, cycle: float) -> float:
        return Growth(1e-3 * self.um_per_N, self.cycles, self.power).at(cycle)
