"""Sensor lag: one channel is read later than the other."""

from dataclasses import dataclass, replace

from wirewear.base.quantity import Quantity
from wirewear.effects.effect import Effect
from wirewear.effects.measurements import ENCODER, LOWER_FREQUENCY, SECOND_HEIGHT
from wirewear.effects.parameter import choice, parameter
from wirewear.effects.seams import Age, Ageing, Seam
from wirewear.loops.sensor import Sensor


@dataclass(frozen=True)
class SensorLag(Effect[Sensor]):
    """A displacement channel that lags behind the force channel, or a force channel behind the displacement.

    A first-order filter of time constant τ, as of an amplifier, delays its channel by about τ: a loop without friction
    work gets the area of an ellipse, π Q* δ* ω τ, and branches split at their reversals. A force that lags parts them
    the other way. Source: Bendat & Piersol, Random Data, 4th ed., section 2.3.
    """

    name = "sensor_lag"
    seam = Seam.SENSOR
    ages = Ageing.NEVER
    signature = "branches split at the reversals, elastic loops gain area, in proportion to the frequency"
    confused_with = ()
    answers = (
        SECOND_HEIGHT.shows("the second sensor shows what the first does not"),
        ENCODER.shows("one of the rig's channels comes late"),
        LOWER_FREQUENCY.shows("the branches close up"),
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
        """The sensor with this lag added to its own."""
        if self.channel == "force":
            return replace(described, force_lag_s=described.force_lag_s + self.time_s)
        return replace(described, lag_s=described.lag_s + self.time_s)
