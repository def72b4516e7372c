from dataclasses import dataclass, replace

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World


@dataclass(frozen=True)
class LopsidedWear(Cause):
    """A draught blows debris off one end of the track, which wears more than the end where it lies and protects."""

    seam = "wear"
    sets = (("reserved", 13),)

    slant: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"slant": d.between(0.08, 0.8) * d.sign()}

    def in_world(self, world: World) -> World:
        return replace(world, wear=replace(world.wear, slant=self.slant))
