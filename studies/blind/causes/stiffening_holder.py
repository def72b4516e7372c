from dataclasses import dataclass, replace

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World


@dataclass(frozen=True)
class StiffeningHolder(Cause):
    """A holder that gives way under small forces and stiffens, as a joint that closes does."""

    seam = "holder"
    sets = (("sealed", 3),)

    hardening_um_per_N3: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"hardening_um_per_N3": d.length_um(1.0, 9.0) / d.plateau_N**3}

    def in_world(self, world: World) -> World:
        return replace(world, rig=replace(world.rig, hardening_mm_per_N3=1e-3 * self.hardening_um_per_N3))
