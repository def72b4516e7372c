"""Force crosstalk: each channel of the force cell reads a share of the other."""

from dataclasses import dataclass, replace

from wirewear.base.quantity import Quantity
from wirewear.effects.effect import Effect
from wirewear.effects.measurements import HALF_LOAD, NORMAL_FORCE
from wirewear.effects.parameter import parameter
from wirewear.effects.seams import Age, Ageing, Seam
from wirewear.loops.sensor import Sensor


@dataclass(frozen=True)
class ForceCrosstalk(Effect[Sensor]):
    """A force cell whose channels read a share of each other.

    Q' = Q + c P and P' = P + c Q: the loop is offset by c P, and the normal force ripples with the friction. Source:
    data sheets of multi-axis load cells, which state 0.5 to 3 %.
    """

    name = "force_crosstalk"
    seam = Seam.SENSOR
    ages = Ageing.NEVER
    signature = "force offset ∝ normal load, normal force ripples with the tangential one; energy unchanged"
    confused_with = ("misalignment",)
    answers = (
        NORMAL_FORCE.shows("it ripples with the motion"),
        HALF_LOAD.shows("an offset in proportion to the load even without contact"),
    )

    coefficient: float = parameter(
        "share of each force that the other's channel reads",
        Quantity("1", -0.5, 0.5),
        neutral=0.0,
        easy=0.03,
        hard=0.007,
        interest=(-0.05, 0.05),
    )

    def changed(self, described: Sensor, _age: Age) -> Sensor:
        """The sensor with this crosstalk added to its own."""
        return replace(described, force_crosstalk=described.force_crosstalk + self.coefficient)
