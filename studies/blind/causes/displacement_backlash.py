from dataclasses import dataclass, replace

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World


@dataclass(frozen=True)
class DisplacementBacklash(Cause):
    """The displacement sensor comes after the motion by a play, as one behind a lever does."""

    seam = "sensor"
    sets = (("development", 3),)

    play_um: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"play_um": d.length_um(0.6, 6.0)}

    def in_world(self, world: World) -> World:
        return replace(world, sensors=replace(world.sensors, displacement_play_mm=1e-3 * self.play_um))
