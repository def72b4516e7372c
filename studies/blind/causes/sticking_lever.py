from dataclasses import dataclass

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals, loaded, turned


@dataclass(frozen=True)
class StickingLever(Reading):
    """The lever of the dead weights sticks in its pivot, so that the load is more one way than the other."""

    seam = "loading"
    sets = (("unseen", 6),)

    share: float
    over_um: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"share": d.between(0.006, 0.08) * d.sign(), "over_um": d.nominal.amplitude_um * d.spread(0.05, 0.3)}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        return loaded(signals, 1.0 + self.share * turned(signals.displacement_um, self.over_um))
