from dataclasses import dataclass, replace

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World


@dataclass(frozen=True)
class RolledWire(Cause):
    """Rollers that straightened the fixed wire left its section an ellipse, which lies flat or stands on edge."""

    seam = "specimens"
    sets = (("withheld", 19),)

    crown_factor: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"crown_factor": d.between(1.2, 2.2) ** d.sign(0.7)}

    def in_world(self, world: World) -> World:
        return replace(world, specimens=replace(world.specimens, fixed_crown=self.crown_factor))
