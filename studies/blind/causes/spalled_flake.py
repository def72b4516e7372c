from dataclasses import dataclass, replace

import numpy as np

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.foundation import Grid, Shapes
from studies.blind.generators.independent.world import World


@dataclass(frozen=True)
class SpalledFlake(Cause):
    """A crack below the scar comes to the surface, and a flake breaks out of the fixed wire (Suh, Wear 25 (1973) 111).

    It leaves a pit, a paraboloid with its middle so far off.
    """

    seam = "wear"
    sets = (("reserved", 14),)

    cycle: float
    depth_um: float
    radius_um: float
    x_um: float
    y_um: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        # Late, as cracks take their time, and within the scar.
        half_um = 1e3 * d.nominal.expected_scar_mm
        return {
            "cycle": d.nominal.cycles * d.random.uniform(0.5, 0.95),
            "depth_um": d.scar_depth_um * d.between(0.08, 0.5),
            "radius_um": half_um * d.random.uniform(0.2, 0.45),
            "x_um": half_um * d.random.uniform(-0.3, 0.3),
            "y_um": half_um * d.random.uniform(-0.3, 0.3),
        }

    def befallen(self, grid: Grid, shapes: Shapes) -> Shapes:
        """The fixed wire with its pit."""
        x_mm, y_mm, radius_mm = 1e-3 * self.x_um, 1e-3 * self.y_um, 1e-3 * self.radius_um
        off = np.hypot(grid.x_mm[None, :] - x_mm, grid.y_mm[:, None] - y_mm) / radius_mm
        return replace(shapes, fixed=shapes.fixed + 1e-3 * self.depth_um * np.maximum(1.0 - off**2, 0.0))

    def in_world(self, world: World) -> World:
        return replace(world, incidents=(*world.incidents, self))
