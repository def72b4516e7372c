from dataclasses import dataclass, replace

from studies.blind.causes.cause import ReadingOfTest, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.signals import Instrument, Signals, bent


@dataclass(frozen=True)
class Bend:
    """Right at both ends and in the middle of ±amplitude."""

    share: float
    amplitude_um: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The displacement with its bend."""
        added = bent(signals.displacement_um, self.amplitude_um, self.share)
        return replace(signals, displacement_um=signals.displacement_um + added)


@dataclass(frozen=True)
class BentDisplacementSensor(ReadingOfTest):
    """The displacement sensor is not straight: right at both ends and the middle of the asked stroke, wrong between."""

    seam = "sensor"
    sets = (("sealed", 2),)

    bend: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"bend": d.between(0.02, 0.2) * d.sign()}

    def instrument(self, nominal: Nominal) -> Instrument:
        return Bend(self.bend, nominal.amplitude_um)

    def in_world(self, world: World) -> World:
        return replace(world, sensors=replace(world.sensors, displacement_cubic=self.bend))
