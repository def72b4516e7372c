from dataclasses import dataclass, replace

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Signals, turned


@dataclass(frozen=True)
class DraggingGuide(Reading):
    """A bearing of the stage drags behind the force cell, which bears its dry friction beside that of the wires."""

    seam = "sensor"
    sets = (("unseen", 5),)

    force_N: float
    over_um: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"force_N": d.between(0.02, 0.2) * d.plateau_N, "over_um": d.nominal.amplitude_um * d.spread(0.02, 0.1)}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        drag = self.force_N * turned(signals.displacement_um, self.over_um)
        return replace(signals, tangential_force_N=signals.tangential_force_N + drag)
