from dataclasses import dataclass, replace
from math import pi

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World


@dataclass(frozen=True)
class PressureDependentWear(Cause):
    """Work wears more, or less, where the pressure is high, as mild wear turns severe (Archard & Hirst 1956)."""

    seam = "wear"
    sets = (("unseen", 12),)

    exponent: float
    pressure_MPa: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        # The reference is the mean pressure on the expected scar, so that the end of the test is as stated.
        pressure_MPa = d.nominal.load_N / (pi * d.nominal.expected_scar_mm**2)
        return {"exponent": d.between(0.06, 0.5) * d.sign(), "pressure_MPa": pressure_MPa}

    def in_world(self, world: World) -> World:
        wear = replace(world.wear, pressure_exponent=self.exponent, reference_MPa=self.pressure_MPa)
        return replace(world, wear=wear)
