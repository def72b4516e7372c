"""Misalignment: the motion leans against the load."""

from dataclasses import dataclass, replace
from math import radians

from wirewear.base.quantity import Quantity
from wirewear.effects.effect import Effect
from wirewear.effects.measurements import HALF_LOAD, NORMAL_FORCE
from wirewear.effects.parameter import parameter
from wirewear.effects.seams import Age, Ageing, Loading, Seam


@dataclass(frozen=True)
class Misalignment(Effect[Loading]):
    """A motion that is not parallel to the plane of contact.

    The line of motion rises by β out of the contact plane, so the holder climbs on one stroke and descends on the
    other: Q = P tan(φ + β) out and P tan(φ − β) back, with tan φ = µ. The mean force is P tan β (1 + µ²), and a loading
    spring's force ripples in phase with the motion. Source: statics of the inclined plane; Schmitz, Action, Ziegert &
    Sawyer, J. Tribol. 127 (2005) 673, on axes of force that are not aligned with the motion.
    """

    name = "misalignment"
    seam = Seam.LOADING
    ages = Ageing.NEVER
    needs_load = True
    signature = "a mean force P·tan β (1 + µ²); with a loading spring, load ripple in phase with the motion"
    confused_with = ("force_crosstalk",)
    answers = (
        NORMAL_FORCE.shows("it ripples with the motion"),
        HALF_LOAD.shows("half the offset at half the load, none without contact"),
    )

    angle_deg: float = parameter(
        "rise of the line of motion out of the contact plane",
        Quantity("deg", -20.0, 20.0),
        neutral=0.0,
        easy=2.0,
        hard=0.4,
        interest=(-3.0, 3.0),
    )

    def changed(self, described: Loading, _age: Age) -> Loading:
        """The loading with the motion leaning so much more."""
        return replace(described, misalignment_rad=described.misalignment_rad + radians(self.angle_deg))
