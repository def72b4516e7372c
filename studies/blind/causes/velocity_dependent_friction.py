from dataclasses import dataclass, replace

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World


@dataclass(frozen=True)
class VelocityDependentFriction(Cause):
    """Friction that changes with the logarithm of the speed."""

    seam = "contact"
    sets = (("first", 2), ("sealed", 7))

    per_e_fold: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"per_e_fold": d.between(0.015, 0.12) * d.sign()}

    def in_world(self, world: World) -> World:
        return replace(world, friction=replace(world.friction, velocity_sensitivity=self.per_e_fold))
