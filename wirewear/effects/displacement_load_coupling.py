"""Displacement load coupling: the displacement reading follows the tangential force."""

from dataclasses import dataclass, replace

from wirewear.base.quantity import Quantity
from wirewear.effects.effect import Effect
from wirewear.effects.measurements import EARLY_LOOPS, ENCODER, HALF_LOAD, LOWER_FREQUENCY, SECOND_HEIGHT
from wirewear.effects.parameter import parameter
from wirewear.effects.seams import Age, Ageing, Seam
from wirewear.loops.sensor import Sensor


@dataclass(frozen=True)
class DisplacementLoadCoupling(Effect[Sensor]):
    """A displacement reading that depends on the tangential force.

    δ' = δ + k₁ Q + k₂ Q²: the sensor looks at a point that yields under the load, linearly and, with a gap or a curved
    support, in the square. Neither changes the loop's area, as ∮Q df(Q) = 0. Source: Infante-García et al., Sensors 20
    (2020) 4152, section 2.1 (second-order polynomial of the load).
    """

    name = "displacement_load_coupling"
    seam = Seam.SENSOR
    ages = Ageing.NEVER
    signature = "false compliance, stick slopes unequal on both branches; energy unchanged"
    confused_with = ("tangential_compliance", "rotational_compliance")
    answers = (
        SECOND_HEIGHT.shows("the second sensor shows what the first does not"),
        ENCODER.shows("the rig's sensor leans"),
        HALF_LOAD.shows("a lean of the same slope at half the load"),
        LOWER_FREQUENCY.shows("the lean stays"),
        EARLY_LOOPS.shows("the stick branch stays"),
    )
    prior_weight = 0.5

    linear_um_per_N: float = parameter(
        "displacement read per tangential force",
        Quantity("um_per_N", -1e3, 1e3),
        neutral=0.0,
        easy=5.0,
        hard=0.7,
        interest=(-8.0, 8.0),
    )
    quadratic_um_per_N2: float = parameter(
        "displacement read per square of the tangential force",
        Quantity("um_per_N2", -1e3, 1e3),
        neutral=0.0,
        easy=1.0,
        hard=0.15,
        interest=(-2.0, 2.0),
    )

    def changed(self, described: Sensor, _age: Age) -> Sensor:
        """The sensor with this polynomial added to its own."""
        return replace(
            described,
            linear_um_per_N=described.linear_um_per_N + self.linear_um_per_N,
            quadratic_um_per_N2=described.quadratic_um_per_N2 + self.quadratic_um_per_N2,
        )
