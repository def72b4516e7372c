"""Displacement gain: the displacement sensor reads too much or too little."""

from dataclasses import dataclass, replace

from wirewear.base.quantity import Quantity
from wirewear.effects.effect import Effect
from wirewear.effects.measurements import ENCODER, LOWER_FREQUENCY, SCAR_MAPS, SECOND_HEIGHT
from wirewear.effects.parameter import parameter
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
    confused_with = ("tangential_compliance",)
    answers = (
        SECOND_HEIGHT.shows("the second sensor shows what the first does not"),
        ENCODER.shows("the rig's sensor reads another stroke"),
        LOWER_FREQUENCY.shows("the stretch stays"),
        SCAR_MAPS.shows("lengths that contradict the stroke read"),
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
        """The sensor with its gain times this one."""
        return replace(described, displacement_gain=self.gain * described.displacement_gain)
