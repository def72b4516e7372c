from dataclasses import dataclass, replace

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World


@dataclass(frozen=True)
class AsymmetricForceCell(Cause):
    """The force cell reads one sign larger than the other."""

    seam = "sensor"
    sets = (("development", 0),)

    asymmetry: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"asymmetry": d.between(0.01, 0.1) * d.sign()}

    def in_world(self, world: World) -> World:
        return replace(world, sensors=replace(world.sensors, force_asymmetry=self.asymmetry))
