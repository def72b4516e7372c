from dataclasses import dataclass, replace

import numpy as np

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World
from studies.blind.generators.signals import Array


@dataclass(frozen=True)
class OpeningJoint(Cause):
    """A joint of the holder whose screws were tightened too little opens under the largest forces, either way.

    Its faces part once the force exceeds the preload of its screws: c sign(Q) max(|Q| − Q_0, 0). Below the preload the
    faces bear the force, above it the screws alone do (VDI 2230, joint diagram). It is elastic.
    """

    seam = "holder"
    sets = (("withheld", 11),)

    preload_N: float
    um_per_N: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        preload = d.random.uniform(0.35, 0.75) * d.plateau_N
        return {"preload_N": preload, "um_per_N": d.length_um(0.4, 3.5) / (d.plateau_N - preload)}

    def moved_mm(self, force_N: Array, _held_from_N: float, _direction: int) -> Array:
        """What the screws stretch by (n,)."""
        return np.asarray(1e-3 * self.um_per_N * (force_N - np.clip(force_N, -self.preload_N, self.preload_N)))

    def in_world(self, world: World) -> World:
        return replace(world, rig=replace(world.rig, joints=(*world.rig.joints, self)))
