from dataclasses import dataclass, replace

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World


@dataclass(frozen=True)
class UsedWire(Cause):
    """The fixed wire was used before and not turned far enough: the contact lies on the flank of its old scar."""

    seam = "specimens"
    sets = (("withheld", 18),)

    depth_um: float
    aside_um: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {
            "depth_um": d.scar_depth_um * d.between(0.12, 0.55),
            "aside_um": 1e3 * d.nominal.expected_scar_mm * d.random.uniform(0.1, 0.5) * d.sign(),
        }

    def in_world(self, world: World) -> World:
        scar_mm, aside_mm = 1e-3 * self.depth_um, 1e-3 * self.aside_um
        return replace(world, specimens=replace(world.specimens, old_scar_mm=scar_mm, old_scar_aside_mm=aside_mm))
