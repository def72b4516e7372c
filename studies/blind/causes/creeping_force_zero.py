from dataclasses import dataclass, replace

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World
from studies.blind.generators.signals import Signals
from wirewear.base.course import Course


@dataclass(frozen=True)
class CreepingForceZero(Reading):
    """The zero of the force creeps, as that of a charge amplifier does."""

    seam = "sensor"
    sets = (("sealed", 1),)

    zero_N: float
    cycles: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"zero_N": d.between(0.02, 0.2) * d.plateau_N * d.sign(), "cycles": d.cycles}

    @property
    def course(self) -> Course:
        """The zero over the cycles [N]."""
        return Course(0.0, self.zero_N, self.cycles)

    def read(self, signals: Signals, cycle: float) -> Signals:
        return replace(signals, tangential_force_N=signals.tangential_force_N + self.course.at(cycle))

    def in_world(self, world: World) -> World:
        return replace(world, sensors=replace(world.sensors, force_zero_N=self.course))
