"""An effect that wirewear does not have: friction that follows the dissipated energy instead of the cycles."""

from dataclasses import dataclass, replace
from math import exp

from wirewear.effects import Age, ContactLaw, Effect, Quantity, Seam, parameter
from wirewear.effects.measurements import EARLY_LOOPS, NORMAL_FORCE, OTHER_STROKE


@dataclass(frozen=True)
class FrictionByEnergy(Effect[ContactLaw]):
    """Friction that tends to a final value with the dissipated energy.

    µ(E) = µ_f + (µ − µ_f)(1 − exp(−E/E_c)): as friction_evolution, but tests of all strokes agree at equal energy.
    """

    name = "friction_by_energy"
    seam = Seam.CONTACT
    signature = "the loop's height drifts with the dissipated energy"
    confused_with = ("friction_evolution", "normal_load_drift")
    answers = (
        OTHER_STROKE.shows("the same course over the dissipated energy"),
        NORMAL_FORCE.shows("as modelled, under friction that changes"),
        EARLY_LOOPS.shows("only the height changes"),
    )

    final: float = parameter(
        "coefficient of friction in the end",
        Quantity("1", 0.0, 2.0),
        neutral=1.0,
        easy=0.8,
        hard=0.95,
        interest=(0.7, 1.4),
        logarithmic=True,
        share_of="contact.friction",
    )
    energy_J: float = parameter(
        "energy after which 63 % of the change has happened",
        Quantity("J", 1e-6, 1e6),
        neutral=None,
        easy=1.0,
        hard=1.0,
        interest=(0.01, 100.0),
        logarithmic=True,
    )

    def changed(self, described: ContactLaw, age: Age) -> ContactLaw:
        """The law with the coefficient at that energy."""
        come = 1.0 - exp(-age.energy_J / self.energy_J)
        return replace(described, friction=described.friction + (self.final - described.friction) * come)
