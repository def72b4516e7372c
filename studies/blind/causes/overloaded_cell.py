from dataclasses import dataclass, replace

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals


@dataclass(frozen=True)
class OverloadedCell(Reading):
    """A force cell is overloaded at some cycle: its gauges yield, read less ever after, and no longer return to zero.

    Q before, (1 − loss) Q + zero after it; makers of cells name both as the signs of an overload.
    """

    seam = "sensor"
    sets = (("withheld", 0),)

    loss: float
    zero_N: float
    cycle: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {
            "loss": d.between(0.02, 0.2),
            "zero_N": d.between(0.003, 0.03) * d.plateau_N * d.sign(),
            "cycle": d.nominal.cycles * d.spread(0.02, 0.25),
        }

    def read(self, signals: Signals, cycle: float) -> Signals:
        if cycle < self.cycle:
            return signals
        return replace(signals, tangential_force_N=(1.0 - self.loss) * signals.tangential_force_N + self.zero_N)
