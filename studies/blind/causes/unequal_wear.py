from dataclasses import dataclass, replace

from studies.blind.causes.cause import Sizes, WearChange
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World


@dataclass(frozen=True)
class UnequalWear(WearChange):
    """One wire is harder than the other, as from another batch, so that the other one wears more; both as stated."""

    seam = "wear"
    sets = (("unseen", 11),)

    moving_share: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"moving_share": 0.5 + d.between(0.05, 0.4) * d.sign()}

    def rates(self, upper: float, lower: float, _cycle: float) -> tuple[float, float]:
        both = upper + lower
        moving = self.moving_share * both
        return both - moving, moving

    def in_world(self, world: World) -> World:
        return replace(world, wear=replace(world.wear, moving_share=self.moving_share))
