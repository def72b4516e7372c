from dataclasses import dataclass, replace

import numpy as np

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World
from studies.blind.generators.signals import Array


@dataclass(frozen=True)
class ClampSlip(Cause):
    """A clamp that slips, with hysteresis, once the force has swung by more than twice what it holds."""

    seam = "holder"
    sets = (("first", 3), ("development", 4))

    holds_N: float
    slip_um_per_N: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        holds = d.random.uniform(0.3, 0.7) * d.plateau_N
        return {"holds_N": holds, "slip_um_per_N": d.length_um(0.8, 6.0) / (d.plateau_N - holds)}

    def moved_mm(self, force_N: Array, held_from_N: float, direction: int) -> Array:
        """How far it has slipped: the play operator on the force (n,)."""
        rest = held_from_N + direction * self.holds_N
        swing = np.maximum.accumulate(direction * (force_N - direction * self.holds_N))
        return np.asarray(1e-3 * self.slip_um_per_N * direction * np.maximum(swing, direction * rest))

    def in_world(self, world: World) -> World:
        return replace(world, rig=replace(world.rig, joints=(*world.rig.joints, self)))
