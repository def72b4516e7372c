from dataclasses import dataclass, replace

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World
from studies.blind.generators.signals import Signals, after_play


@dataclass(frozen=True)
class ForceCellHysteresis(Reading):
    """The force cell comes after the force by a play, as a glued or worn flexure does."""

    seam = "sensor"
    sets = (("sealed", 0),)

    play_N: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"play_N": d.between(0.02, 0.2) * d.plateau_N}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        return replace(signals, tangential_force_N=after_play(signals.tangential_force_N, self.play_N))

    def in_world(self, world: World) -> World:
        return replace(world, sensors=replace(world.sensors, force_play_N=self.play_N))
