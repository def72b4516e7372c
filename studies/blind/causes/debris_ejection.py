from dataclasses import dataclass, replace
from math import prod

from studies.blind.causes.cause import FrictionFactor, Sizes
from studies.blind.generators.ageing import Jump
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World


@dataclass(frozen=True)
class DebrisEjection(FrictionFactor):
    """Debris leaves the scar at once: friction jumps to a multiple and comes back over further cycles, twice."""

    seam = "contact"
    sets = (("first", 4), ("development", 8))

    factor: float
    cycle_1: float
    cycle_2: float
    recovery_cycles: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        cycles = d.nominal.cycles
        return {
            "factor": 1.0 + d.between(0.04, 0.25) * d.sign(0.3),
            "cycle_1": cycles * d.random.uniform(0.02, 0.1),
            "cycle_2": cycles * d.random.uniform(0.3, 0.8),
            "recovery_cycles": cycles * d.random.uniform(0.05, 0.2),
        }

    @property
    def jumps(self) -> tuple[Jump, Jump]:
        return (
            Jump(self.cycle_1, self.factor, self.recovery_cycles),
            Jump(self.cycle_2, self.factor, self.recovery_cycles),
        )

    def at(self, cycle: float) -> float:
        return prod(jump.at(cycle) for jump in self.jumps)

    def in_world(self, world: World) -> World:
        return replace(world, friction=replace(world.friction, events=(*world.friction.events, *self.jumps)))
