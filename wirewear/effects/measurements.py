"""Further measurements beyond a record's loops, by which effects are distinguished.

Two effects are distinguished by a measurement that would show different answers under them.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Measurement:
    """A measurement that laboratories can make, why it distinguishes effects, its cost in days of work."""

    what: str
    why: str
    cost_days: float
    without_gap: str = ""  #: What it shows if the nominal model is right; empty if that distinguishes nothing.

    def shows(self, text: str) -> "Answer":
        """The answer of this measurement under an effect, in words; effects with equal words look alike to it."""
        return Answer(self, text)


@dataclass(frozen=True)
class Answer:
    """What a measurement would show under an effect, as part of a sentence."""

    measurement: Measurement
    text: str


SECOND_HEIGHT = Measurement(
    "a second displacement sensor at another height above the contact",
    "a tilting holder moves both points differently, a sliding one alike",
    cost_days=1.0,
)

ENCODER = Measurement(
    "one loop with the stroke held by a sensor that bears no load (an encoder on the drive)",
    "a sensor's error leaves the true stroke and the dissipated energy as they are, a compliance does not",
    cost_days=0.5,
)

NORMAL_FORCE = Measurement(
    "the normal force over whole cycles", "a drifting or wrong load shows in it, friction does not", cost_days=0.3
)

HALF_LOAD = Measurement(
    "a stroke without contact and one with half the load",
    "offsets that follow the load are the sensor's or the load's direction, those that follow friction are not",
    cost_days=0.3,
)

INTERRUPTED_SCARS = Measurement(
    "scars of tests stopped after 1 to 10, 1 000 and 30 000 cycles",
    "the path of the worn volume distinguishes an early flattening, a wrong and a changing wear rate",
    cost_days=3.0,
)

LOWER_FREQUENCY = Measurement(
    "the same test at a tenth of the frequency",
    "a lag and heat shrink with the frequency, everything elastic stays",
    cost_days=0.5,
)

EARLY_LOOPS = Measurement(
    "loops every half decade from the first cycle on",
    "a rough surface wears in, debris gathers, a rig stays as it is",
    cost_days=0.2,
)

SCAR_MAPS = Measurement(
    "maps of both scars",
    "their volume, length and skew show true stroke, wear and angle without any sensor of the rig",
    cost_days=0.5,
    without_gap="lengths, volumes and outlines as modelled",
)

OTHER_STROKE = Measurement(
    "the same test at half the stroke",
    "what follows the cycles agrees at equal cycles, what follows the dissipated energy at equal energy",
    cost_days=1.0,
)

CLEANED_SCARS = Measurement(
    "maps of both scars before and after debris is cleaned out of them",
    "debris hides the depth that it fills, other wear does not",
    cost_days=1.0,
)

#: Measurements that most laboratories can make.
LIBRARY = (
    SECOND_HEIGHT, ENCODER, NORMAL_FORCE, HALF_LOAD, INTERRUPTED_SCARS, LOWER_FREQUENCY, EARLY_LOOPS, SCAR_MAPS,
    OTHER_STROKE, CLEANED_SCARS,
)  # fmt: skip
