from dataclasses import dataclass, replace

from studies.blind.causes.cause import Cause, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World


@dataclass(frozen=True)
class ReversalAdhesion(Cause):
    """The wires stick at rest: friction overshoots after each reversal and falls back over some length."""

    seam = "contact"
    sets = (("first", 1), ("development", 7))

    overshoot: float
    length_um: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"overshoot": d.between(0.06, 0.4), "length_um": d.random.uniform(2.0, 6.0)}

    def in_world(self, world: World) -> World:
        friction = replace(world.friction, adhesion=self.overshoot, adhesion_length_mm=1e-3 * self.length_um)
        return replace(world, friction=friction)
