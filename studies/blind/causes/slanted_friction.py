from dataclasses import dataclass, replace

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World


@dataclass(frozen=True)
class SlantedFriction(Cause):
    """Friction is higher at one end of the stroke, as where a specimen was ground the other way."""

    seam = "contact"
    sets = (("sealed", 5),)

    rise: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"rise": d.between(0.03, 0.25) * d.sign()}

    def in_world(self, world: World) -> World:
        return replace(world, friction=replace(world.friction, slant=self.rise))
