"""Effects of the sensors: gain, dependence on force, crosstalk and lag."""

from dataclasses import dataclass, replace

from wirewear.base.units import Quantity
from wirewear.effects import measurements
from wirewear.effects.effect import Effect
from wirewear.effects.parameter import choice, parameter
from wirewear.effects.seams import Age, Ageing, Seam
from wirewear.loops.sensor import Sensor


@dataclass(frozen=True)
class DisplacementGain(Effect[Sensor]):
    """A displacement sensor with a wrong gain.

    δ' = g δ: the whole loop is stretched, its stick slopes fall by g and its area grows by g, at every load and cycle.
    Source: calibration of sensors; Infante-García et al., Sensors 20 (2020) 4152, section 2.1.
    """

    name = "displacement_gain"
    seam = Seam.SENSOR
    ages = Ageing.NEVER
    signature = "the whole loop is stretched, slip and displacement amplitude alike; scar lengths contradict the stroke"
    remedy = "calibrate the displacement sensor, and check its angle to the motion"
    confused_with = ("tangential_compliance",)
    answers = (
        measurements.SECOND_HEIGHT.shows("the second sensor shows what the first does not"),
        measurements.ENCODER.shows("the rig's sensor reads another stroke"),
        measurements.LOWER_FREQUENCY.shows("the stretch stays"),
        measurements.SCAR_MAPS.shows("lengths that contradict the stroke read"),
    )

    gain: float = parameter(
        "read over true displacement",
        Quantity("1", 0.1, 10.0),
        neutral=1.0,
        easy=1.05,
        hard=1.012,
        interest=(0.9, 1.1),
        logarithmic=True,
    )

    def changed(self, described: Sensor, _age: Age) -> Sensor:
        return replace(described, displacement_gain=self.gain * described.displacement_gain)


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
    remedy = "push on the rig without sliding and watch the displacement sensor; mount it off what carries the force"
    confused_with = ("tangential_compliance", "rotational_compliance")
    answers = (
        measurements.SECOND_HEIGHT.shows("the second sensor shows what the first does not"),
        measurements.ENCODER.shows("the rig's sensor leans"),
        measurements.HALF_LOAD.shows("a lean of the same slope at half the load"),
        measurements.LOWER_FREQUENCY.shows("the lean stays"),
        measurements.EARLY_LOOPS.shows("the stick branch stays"),
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
        return replace(
            described,
            linear_um_per_N=described.linear_um_per_N + self.linear_um_per_N,
            quadratic_um_per_N2=described.quadratic_um_per_N2 + self.quadratic_um_per_N2,
        )


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
    remedy = "press without moving and read the tangential force; align the force cell"
    confused_with = ("misalignment",)
    answers = (
        measurements.NORMAL_FORCE.shows("it ripples with the motion"),
        measurements.HALF_LOAD.shows("an offset in proportion to the load even without contact"),
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
        return replace(described, force_crosstalk=described.force_crosstalk + self.coefficient)


@dataclass(frozen=True)
class SensorLag(Effect[Sensor]):
    """A displacement channel that lags behind the force channel, or a force channel behind the displacement.

    A first-order filter of time constant τ, as of an amplifier, delays its channel by about τ: a loop without friction
    work gets the area of an ellipse, π Q* δ* ω τ, and its branches separate near the reversals. A force that lags
    separates them in the other direction. Source: Bendat & Piersol, Random Data, 4th ed., section 2.3.
    """

    name = "sensor_lag"
    seam = Seam.SENSOR
    ages = Ageing.NEVER
    signature = "branches split at the reversals, elastic loops gain area, in proportion to the frequency"
    remedy = "record both channels through like filters, and check their time stamps"
    confused_with = ()
    answers = (
        measurements.SECOND_HEIGHT.shows("the second sensor shows what the first does not"),
        measurements.ENCODER.shows("one of the rig's channels comes late"),
        measurements.LOWER_FREQUENCY.shows("the branches close up"),
    )

    time_s: float = parameter(
        "time constant of the lag",
        Quantity("s", 0.0, 10.0),
        neutral=0.0,
        easy=0.003,
        hard=0.0004,
        interest=(1e-4, 0.02),
        logarithmic=True,
    )

    channel: str = choice("displacement", "force")

    def changed(self, described: Sensor, _age: Age) -> Sensor:
        if self.channel == "force":
            return replace(described, force_lag_s=described.force_lag_s + self.time_s)
        return replace(described, lag_s=described.lag_s + self.time_s)
