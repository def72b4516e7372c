"""Friction evolution: the coefficient of friction changes over the test."""

from dataclasses import dataclass, replace

from wirewear.base.course import Course
from wirewear.base.quantity import Quantity
from wirewear.effects.effect import Effect
from wirewear.effects.measurements import EARLY_LOOPS, INTERRUPTED_SCARS, NORMAL_FORCE, OTHER_STROKE
from wirewear.effects.parameter import exponent, form, order, parameter
from wirewear.effects.seams import Age, Ageing, ContactLaw, Seam


@dataclass(frozen=True)
class FrictionEvolution(Effect[ContactLaw]):
    """Friction that changes over the test, exponentially towards a final value.

    Running-in strips oxide and contaminants, then oxidised debris builds up: µ(n) = µ_f + (µ_i − µ_f) exp(−n/n_c).
    Source: Blau, Tribol. Int. 34 (2001) 585, on running-in and friction over time.
    """

    name = "friction_evolution"
    seam = Seam.CONTACT
    ages = Ageing.BY_CYCLES
    signature = "the loop's height drifts over the cycles, not tied to the worn depth"
    confused_with = ("normal_load_drift", "friction_offset")
    answers = (
        NORMAL_FORCE.shows("as modelled, under friction that changes"),
        INTERRUPTED_SCARS.shows("volumes that follow the measured energy"),
        EARLY_LOOPS.shows("only the height changes"),
        OTHER_STROKE.shows("the same course over the cycles"),
    )
    # What its forms leave of ten laws over three decades, in the mean square: 2 % (0 to 3.4 %).
    model_error = 0.03

    initial: float = parameter(
        "coefficient of friction at the start",
        Quantity("1", 0.0, 2.0),
        neutral=1.0,
        easy=0.7,
        hard=0.93,
        interest=(0.4, 1.5),
        logarithmic=True,
        share_of="contact.friction",
    )
    final: float = parameter(
        "coefficient of friction in the end",
        Quantity("1", 0.0, 2.0),
        neutral=1.0,
        easy=1.0,
        hard=1.0,
        interest=(0.75, 1.3),
        logarithmic=True,
        share_of="contact.friction",
    )
    cycles: float = parameter(
        "cycles after which 63 % of the change has happened",
        Quantity("cycles", 1.0, 1e9),
        neutral=None,
        easy=3000.0,
        hard=3000.0,
        interest=(30.0, 1e5),
        logarithmic=True,
    )

    steepness: float = form(exponent(0.55))
    order: float = form(order(0.7))

    def changed(self, described: ContactLaw, age: Age) -> ContactLaw:
        """The law with the coefficient of that cycle."""
        course = Course(self.initial, self.final, self.cycles, self.steepness, self.order)
        return replace(described, friction=course.at(age.cycles))
