from dataclasses import dataclass, replace

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World


@dataclass(frozen=True)
class ParallelSpring(Cause):
    """A cable or a seal pulls beside the contact, and the force cell bears it, too."""

    seam = "sensor"
    sets = (("development", 9),)

    stiffness_N_per_mm: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"stiffness_N_per_mm": 1e3 * d.between(0.02, 0.2) * d.plateau_N / d.nominal.amplitude_um}

    def in_world(self, world: World) -> World:
        return replace(world, sensors=replace(world.sensors, parallel_N_per_mm=self.stiffness_N_per_mm))
