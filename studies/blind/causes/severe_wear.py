from dataclasses import dataclass

from studies.blind.causes.cause import Sizes, WearFactor
from studies.blind.generators.ageing import Jump
from studies.blind.generators.draw import Draw


@dataclass(frozen=True)
class SevereWear(WearFactor):
    """For some time in the middle of the test wear is severe, or nearly stops."""

    seam = "wear"
    sets = (("sealed", 9),)

    factor: float
    cycle: float
    recovery_cycles: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {
            "factor": d.between(2.0, 8.0) ** d.sign(0.7),
            "cycle": d.nominal.cycles * d.random.uniform(0.05, 0.3),
            "recovery_cycles": d.nominal.cycles * d.random.uniform(0.05, 0.3),
        }

    def at(self, cycle: float) -> float:
        return Jump(self.cycle, self.factor, self.recovery_cycles).at(cycle)
