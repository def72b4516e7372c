from dataclasses import dataclass

from studies.blind.generators.other_simulators.causes import OtherCause, Size, Sizes


@dataclass(frozen=True)
class MildWear(OtherCause):
    """Wear turns mild at some cycle."""

    seam = "wear"
    sets = (("others", 10),)

    factor: float
    cycle: float

    @staticmethod
    def size(d: Size) -> Sizes:
        return {"factor": 1.0 / d.between(1.5, 8.0), "cycle": d.any(0.03, 0.4) * d.test.cycles}

    def wear(self, cycle: float) -> float:
        return self.factor if cycle > self.cycle else 1.0
