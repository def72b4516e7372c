"""Wear rate evolution: the wear coefficient changes over the test."""

from dataclasses import dataclass

from solvers import WearRates
from wirewear.base.course import Course
from wirewear.base.quantity import Quantity
from wirewear.effects.effect import Effect
from wirewear.effects.measurements import INTERRUPTED_SCARS, OTHER_STROKE, SCAR_MAPS
from wirewear.effects.parameter import exponent, form, order, parameter
from wirewear.effects.seams import Age, Ageing, Seam


@dataclass(frozen=True)
class WearRateEvolution(Effect[WearRates]):
    """A wear coefficient that changes over the test, exponentially towards a final value.

    Fresh metal wears faster (or slower) than the oxide bed that later carries the load:
    f(n) = f_f + (f_i − f_f) exp(−n/n_c). Infante-García et al., Sensors 20 (2020) 4152, use a variable coefficient
    for the steel wires; running-in is described by Blau, Tribol. Int. 34 (2001) 585.
    """

    name = "wear_rate_evolution"
    seam = Seam.WEAR
    ages = Ageing.BY_CYCLES
    signature = "the path of end hooks and volumes over the cycles, not only their end"
    confused_with = ("wear_rate_offset", "plasticity")
    answers = (
        INTERRUPTED_SCARS.shows("volumes in no constant proportion to the energy"),
        SCAR_MAPS.shows("other volumes at the modelled lengths"),
        OTHER_STROKE.shows("the same course over the cycles"),
    )
    model_error = 0.08

    initial_factor: float = parameter(
        "factor on the wear coefficient at the start",
        Quantity("1", 0.0, 100.0),
        neutral=1.0,
        easy=3.0,
        hard=1.5,
        interest=(0.2, 5.0),
        logarithmic=True,
    )
    final_factor: float = parameter(
        "factor on the wear coefficient in the end",
        Quantity("1", 0.0, 100.0),
        neutral=1.0,
        easy=1.0,
        hard=1.0,
        interest=(0.4, 2.5),
        logarithmic=True,
    )
    cycles: float = parameter(
        "cycles after which 63 % of the change has happened",
        Quantity("cycles", 1.0, 1e9),
        neutral=None,
        easy=1e4,
        hard=1e4,
        interest=(30.0, 1e5),
        logarithmic=True,
    )

    steepness: float = form(exponent(0.55))
    order: float = form(order(0.7))

    def changed(self, described: WearRates, age: Age) -> WearRates:
        """The rates times the factor of that cycle."""
        return described.scaled(
            Course(self.initial_factor, self.final_factor, self.cycles, self.steepness, self.order).at(age.cycles)
        )
