"""Crossing angle error: the wires cross at another angle than stated."""

from dataclasses import dataclass, replace

from wirewear.base.quantity import Quantity
from wirewear.effects.effect import Effect
from wirewear.effects.measurements import INTERRUPTED_SCARS, SCAR_MAPS
from wirewear.effects.parameter import parameter
from wirewear.effects.seams import Age, Ageing, Seam, Specimens


@dataclass(frozen=True)
class CrossingAngleError(Effect[Specimens]):
    """Wires mounted at another angle than the stated one.

    The fixed wire's axis is turned about the contact normal. Near 90° the contact ellipse and the friction force change
    only to second order; the scar's outline turns and skews to first order. Source: geometry; Johnson, Contact
    Mechanics (1985), ch. 4.1, for the ellipse of cylinders crossed at any angle.
    """

    name = "crossing_angle_error"
    seam = Seam.SPECIMENS
    contacts = ("crossed-wires",)
    ages = Ageing.NEVER
    signature = "nothing in loops to first order; a skewed scar"
    confused_with = ()
    answers = (INTERRUPTED_SCARS.shows("skewed outlines"), SCAR_MAPS.shows("skewed outlines"))

    angle_deg: float = parameter(
        "true crossing angle less the stated one",
        Quantity("deg", -15.0, 15.0),
        neutral=0.0,
        easy=5.0,
        hard=1.5,
        interest=(-6.0, 6.0),
    )

    def changed(self, described: Specimens, _age: Age) -> Specimens:
        """Wires at the true angle."""
        return replace(described, crossing_angle_deg=described.crossing_angle_deg + self.angle_deg)
