from dataclasses import dataclass, replace

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World


@dataclass(frozen=True)
class HardSkin(Cause):
    """Drawing has hardened the wires' skin, or annealing softened it, so that wear follows the depth it has reached."""

    seam = "wear"
    sets = (("withheld", 17),)

    factor: float
    depth_um: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {
            "factor": d.between(0.75, 0.2) if d.random.random() < 0.7 else d.between(1.3, 3.0),
            "depth_um": d.scar_depth_um * d.spread(0.1, 0.3),
        }

    def in_world(self, world: World) -> World:
        return replace(world, wear=replace(world.wear, skin_factor=self.factor, skin_mm=1e-3 * self.depth_um))
