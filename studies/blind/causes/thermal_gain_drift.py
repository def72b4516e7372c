from dataclasses import dataclass, replace

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World
from studies.blind.generators.signals import Signals
from wirewear.base.course import Course


@dataclass(frozen=True)
class ThermalGainDrift(Reading):
    """The displacement sensor warms up, and its gain creeps to another value."""

    seam = "sensor"
    sets = (("first", 0), ("development", 2))

    gain_change: float
    cycles: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"gain_change": d.between(0.015, 0.15) * d.sign(), "cycles": d.cycles}

    @property
    def gain(self) -> Course:
        """Of the sensor, over the cycles."""
        return Course(1.0, 1.0 + self.gain_change, self.cycles)

    def read(self, signals: Signals, cycle: float) -> Signals:
        return replace(signals, displacement_um=self.gain.at(cycle) * signals.displacement_um)

    def in_world(self, world: World) -> World:
        return replace(world, sensors=replace(world.sensors, gain=self.gain))
