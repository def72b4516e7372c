from dataclasses import dataclass, replace

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World


@dataclass(frozen=True)
class OtherGauge(Cause):
    """Both wires are of another gauge than stated, as drawn wire is that was taken from the wrong spool."""

    seam = "specimens"
    sets = (("unseen", 14),)

    diameter_factor: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"diameter_factor": d.between(1.12, 1.5) ** d.sign()}

    def in_world(self, world: World) -> World:
        radius_mm = self.diameter_factor * world.specimens.radius_mm
        return replace(world, specimens=replace(world.specimens, radius_mm=radius_mm))
