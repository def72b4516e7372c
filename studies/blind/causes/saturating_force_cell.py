from dataclasses import dataclass, replace

from studies.blind.causes.cause import ReadingOfTest, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.signals import Instrument, Signals


@dataclass(frozen=True)
class CubicLoss:
    """A force cell that reads Q − s Q³ under the force Q; per_N2: s."""

    per_N2: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The tangential force without what the cell loses."""
        force = signals.tangential_force_N
        return replace(signals, tangential_force_N=force - self.per_N2 * force**3)


@dataclass(frozen=True)
class SaturatingForceCell(ReadingOfTest):
    """The force cell reads ever less than it bears: a share of it at the largest friction that is stated."""

    seam = "sensor"
    sets = (("first", 6), ("development", 1))

    loss_at_plateau: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"loss_at_plateau": d.between(0.02, 0.15)}

    def instrument(self, nominal: Nominal) -> Instrument:
        return CubicLoss(self.loss_at_plateau / (nominal.friction * nominal.load_N) ** 2)

    def in_world(self, world: World) -> World:
        peak = world.friction.course.final * world.loading.load_N
        return replace(world, sensors=replace(world.sensors, force_cubic_per_N2=self.loss_at_plateau / peak**2))
