from dataclasses import dataclass
from math import log1p

from studies.blind.generators.other_simulators.causes import OtherCause, Size, Sizes


@dataclass(frozen=True)
class LooseGauge(OtherCause):
    """The glue of the displacement gauge lets go, fast at first: its gain falls with the logarithm of the cycles."""

    seam = "sensor"
    sets = (("others", 2),)

    loss: float

    @staticmethod
    def size(d: Size) -> Sizes:
        return {"loss": d.between(0.015, 0.15)}

    def gain(self, cycle: float, cycles: int) -> float:
        return 1.0 - self.loss * log1p(cycle / 10.0) / log1p(cycles / 10.0)
