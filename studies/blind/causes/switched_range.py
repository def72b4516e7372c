from dataclasses import dataclass

from studies.blind.generators.other_simulators.causes import OtherCause, Size, Sizes
from studies.blind.generators.other_simulators.pair import Array


@dataclass(frozen=True)
class SwitchedRange(OtherCause):
    """The range of the force's amplifier is switched at some cycle, and its scale with it."""

    seam = "sensor"
    sets = (("others", 0),)

    factor: float
    cycle: float

    @staticmethod
    def size(d: Size) -> Sizes:
        return {"factor": 1.0 + d.either(0.02, 0.2), "cycle": d.any(0.02, 0.6) * d.test.cycles}

    def read_N(self, force_N: Array, _limit_N: float, cycle: float) -> Array:
        return force_N * self.factor if cycle > self.cycle else force_N
