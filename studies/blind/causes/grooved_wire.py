from dataclasses import dataclass, replace

import numpy as np

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.foundation import Grid
from studies.blind.generators.independent.world import World
from studies.blind.generators.signals import Array


@dataclass(frozen=True)
class GroovedWire(Cause):
    """The fixed wire was drawn through a chipped die and has a groove along it, where it is to be rubbed.

    A parabola across it, its middle so far aside.
    """

    seam = "specimens"
    sets = (("reserved", 16),)

    depth_um: float
    half_width_um: float
    aside_um: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {
            "depth_um": d.scar_depth_um * d.between(0.012, 0.14),
            "half_width_um": 1e3 * d.nominal.expected_scar_mm * d.random.uniform(0.15, 0.4),
            "aside_um": 1e3 * d.nominal.expected_scar_mm * d.random.uniform(-0.4, 0.4),
        }

    def depth_mm(self, grid: Grid) -> Array:
        """Its depth on the fixed wire's grid (n_y, n_x)."""
        across = (grid.x_mm - 1e-3 * self.aside_um) / (1e-3 * self.half_width_um)
        depth = 1e-3 * self.depth_um * np.maximum(1.0 - across**2, 0.0)
        return np.asarray(np.broadcast_to(depth, (grid.y_mm.size, depth.size)))

    def in_world(self, world: World) -> World:
        return replace(world, specimens=replace(world.specimens, grooves=(*world.specimens.grooves, self)))
