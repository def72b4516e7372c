from dataclasses import dataclass, replace

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals


@dataclass(frozen=True)
class LoosePlug(Reading):
    """A plug of the bridge has a bad contact, whose resistance unbalances it now and then: the zero jumps and returns.

    Q + zero between the first and second, and again between the third and fourth of four cycles.
    """

    seam = "sensor"
    sets = (("withheld", 1),)

    zero_N: float
    cycle_1: float
    cycle_2: float
    cycle_3: float
    cycle_4: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        # Two bad spells, early and late, between them a good one.
        moments = (d.spread(0.004, 0.02), d.spread(0.03, 0.1), d.spread(0.15, 0.3), d.spread(0.45, 0.9))
        zero = d.between(0.004, 0.035) * d.plateau_N * d.sign()
        return {"zero_N": zero, **{f"cycle_{i}": d.nominal.cycles * part for i, part in enumerate(moments, start=1)}}

    def read(self, signals: Signals, cycle: float) -> Signals:
        if not (self.cycle_1 <= cycle < self.cycle_2 or self.cycle_3 <= cycle < self.cycle_4):
            return signals
        return replace(signals, tangential_force_N=signals.tangential_force_N + self.zero_N)
