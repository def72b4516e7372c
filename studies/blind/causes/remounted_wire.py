from dataclasses import dataclass, replace

import numpy as np

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.foundation import Grid, Shapes
from studies.blind.generators.independent.world import World


@dataclass(frozen=True)
class RemountedWire(Cause):
    """The test is stopped for a look at the scar, and the fixed wire is put back turned a little about its axis.

    Its scar then lies aside along the motion.
    """

    seam = "specimens"
    sets = (("reserved", 15),)

    cycle: float
    aside_um: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {
            "cycle": d.nominal.cycles * d.spread(0.1, 0.6),
            "aside_um": 1e3 * d.nominal.expected_scar_mm * d.between(0.01, 0.14) * d.sign(),
        }

    def befallen(self, grid: Grid, shapes: Shapes) -> Shapes:
        """The fixed wire's scar at its new place."""
        places = grid.x_mm - 1e-3 * self.aside_um
        turned = [np.interp(places, grid.x_mm, row, left=0.0, right=0.0) for row in shapes.fixed]
        return replace(shapes, fixed=np.stack(turned))

    def in_world(self, world: World) -> World:
        return replace(world, incidents=(*world.incidents, self))
