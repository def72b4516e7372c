from dataclasses import dataclass, replace

import numpy as np

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World
from studies.blind.generators.signals import Array


@dataclass(frozen=True)
class MicroslippingJoint(Cause):
    """Faces of a joint of the holder slip from their rims inwards, more the further the force has swung.

    h ΔQ²/2 on either branch: a joint's microslip has such lens-shaped loops (Gaul & Nitsche, Applied Mechanics Reviews
    54 (2001) 93); the quadratic law is Rayleigh's. Its loop closes from −h ΔQ_max²/4 to +h ΔQ_max²/4.
    """

    seam = "holder"
    sets = (("withheld", 12),)

    um_per_N2: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"um_per_N2": d.length_um(0.7, 6.0) / d.plateau_N**2}

    def moved_mm(self, force_N: Array, held_from_N: float, direction: int) -> Array:
        """What has slipped since the reversal, around the middle of both reversals (n,)."""
        swung = np.maximum(direction * (force_N - held_from_N), 0.0)
        whole = float(direction * (force_N[-1] - held_from_N))
        return np.asarray(direction * 0.5 * (1e-3 * self.um_per_N2) * (swung**2 - 0.5 * whole**2))

    def in_world(self, world: World) -> World:
        return replace(world, rig=replace(world.rig, joints=(*world.rig.joints, self)))
