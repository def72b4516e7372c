from dataclasses import dataclass, replace

import numpy as np

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World
from studies.blind.generators.signals import Array


@dataclass(frozen=True)
class OneSidedHolder(Cause):
    """The holder leans on a shoulder one way and on its grub screw alone the other way, where it gives way."""

    seam = "holder"
    sets = (("unseen", 13),)

    um_per_N: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"um_per_N": d.length_um(0.8, 8.0) / d.plateau_N * d.sign()}

    def moved_mm(self, force_N: Array, _held_from_N: float, _direction: int) -> Array:
        """What it gives way by under forces of its own sign (n,)."""
        return np.asarray(1e-3 * self.um_per_N * np.maximum(np.sign(self.um_per_N) * force_N, 0.0))

    def in_world(self, world: World) -> World:
        return replace(world, rig=replace(world.rig, joints=(*world.rig.joints, self)))
