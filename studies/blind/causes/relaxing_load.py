from dataclasses import dataclass

from studies.blind.causes.cause import LoadFactor, Sizes
from studies.blind.generators.draw import Draw
from wirewear.base.course import Course


@dataclass(frozen=True)
class RelaxingLoad(LoadFactor):
    """The spring of the load sets soon after it was tightened, and the load with it."""

    seam = "loading"
    sets = (("unseen", 10),)

    loss: float
    cycles: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"loss": d.between(0.025, 0.25), "cycles": d.nominal.cycles * d.spread(0.003, 0.03)}

    def at(self, cycle: float) -> float:
        return Course(1.0, 1.0 - self.loss, self.cycles).at(cycle)
