from dataclasses import dataclass, replace

from studies.blind.generators.other_simulators.causes import OtherCause, Size, Sizes
from studies.blind.generators.other_simulators.world import World


@dataclass(frozen=True)
class UnevenBodies(OtherCause):
    """One body is softer than the other, and loses more of the volume that both wear."""

    seam = "wear"
    sets = (("others", 11),)

    moving_share: float

    @staticmethod
    def size(d: Size) -> Sizes:
        return {"moving_share": 0.5 + d.either(0.08, 0.42)}

    def in_test(self, world: World) -> World:
        return replace(world, moving_share=self.moving_share)
