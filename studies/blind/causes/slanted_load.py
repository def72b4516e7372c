from dataclasses import dataclass, replace

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World


@dataclass(frozen=True)
class SlantedLoad(Cause):
    """The load rises from one end of the stroke to the other, as under a lever that turns."""

    seam = "loading"
    sets = (("sealed", 4),)

    load_rise: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"load_rise": d.between(0.03, 0.25) * d.sign()}

    def in_world(self, world: World) -> World:
        return replace(world, loading=replace(world.loading, slant=self.load_rise))
