from dataclasses import dataclass, replace

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World


@dataclass(frozen=True)
class BentGuide(Cause):
    """The load rises towards both ends of the stroke, as the guide is bent."""

    seam = "loading"
    sets = (("first", 5), ("development", 6))

    load_rise: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"load_rise": d.between(0.03, 0.3) * d.sign()}

    def in_world(self, world: World) -> World:
        return replace(world, loading=replace(world.loading, bowl=self.load_rise))
