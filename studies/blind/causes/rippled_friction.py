from dataclasses import dataclass, replace

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World


@dataclass(frozen=True)
class RippledFriction(Cause):
    """Friction waves along the stroke, as across the marks of a file."""

    seam = "contact"
    sets = (("sealed", 6),)

    share: float
    length_um: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"share": d.between(0.01, 0.1), "length_um": d.nominal.amplitude_um * d.spread(0.08, 0.3)}

    def in_world(self, world: World) -> World:
        friction = replace(world.friction, ripple=self.share, ripple_length_mm=1e-3 * self.length_um)
        return replace(world, friction=friction)
