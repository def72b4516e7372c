"""Friction offset: the coefficient of friction is another one throughout."""

from dataclasses import dataclass, replace

from wirewear.base.quantity import Quantity
from wirewear.effects.effect import Effect
from wirewear.effects.measurements import HALF_LOAD, INTERRUPTED_SCARS, NORMAL_FORCE, SCAR_MAPS
from wirewear.effects.parameter import parameter
from wirewear.effects.seams import Age, Ageing, ContactLaw, Seam


@dataclass(frozen=True)
class FrictionOffset(Effect[ContactLaw]):
    """Another coefficient of friction, constant over the test.

    Coulomb friction with a coefficient other than the stated one: plateau and knee move together, at every cycle. The
    usual estimate from the largest force is too high in deep scars; see Fouvry, Duó & Perruchaut, Wear 257 (2004) 916,
    and the geometry-independent coefficient of Infante-García et al., Sensors 20 (2020) 4152.
    """

    name = "friction_offset"
    seam = Seam.CONTACT
    ages = Ageing.NEVER
    signature = "height and knee of the loop move together, at all cycles"
    confused_with = ("normal_load_drift", "friction_evolution")
    answers = (
        NORMAL_FORCE.shows("as modelled, under friction that is off throughout"),
        HALF_LOAD.shows("half the height at half the load"),
        INTERRUPTED_SCARS.shows("volumes that follow the measured energy"),
        SCAR_MAPS.shows("volumes that follow the measured energy"),
    )

    friction: float = parameter(
        "true coefficient of friction",
        Quantity("1", 0.0, 2.0),
        neutral=1.0,
        easy=0.85,
        hard=0.96,
        interest=(0.75, 1.3),
        logarithmic=True,
        share_of="contact.friction",
    )

    def changed(self, described: ContactLaw, _age: Age) -> ContactLaw:
        """The law with the true coefficient."""
        return replace(described, friction=self.friction)
