"""Effects on the wear coefficient: a different one, one that changes over the test, one that is small without
oxygen.
"""

from dataclasses import dataclass, replace

from solvers import OxygenSupply, WearRates
from wirewear.base import kinds
from wirewear.base.course import Course
from wirewear.base.units import Quantity
from wirewear.effects.effect import Chain, Effect
from wirewear.effects.measurements import CLEANED_SCARS, INTERRUPTED_SCARS, LOWER_FREQUENCY, OTHER_STROKE, SCAR_MAPS
from wirewear.effects.parameter import cycles_of_change, exponent, form, order, parameter
from wirewear.effects.seams import Age, Ageing, Seam


def _factor(of: str, *, easy: float, hard: float, least: float, most: float) -> float:
    meaning, quantity, ends = f"factor on the wear coefficient {of}", Quantity("1", 0.0, 100.0), (least, most)
    return parameter(meaning, quantity, neutral=1.0, easy=easy, hard=hard, interest=ends, logarithmic=True)


@dataclass(frozen=True)
class WearRateOffset(Effect[WearRates]):
    """Another wear coefficient, constant over the test.

    Coefficients of one pair of materials differ by tens of per cent between rigs and laboratories, because debris
    leaves the contact differently. Source: Fouvry et al., Wear 255 (2003) 287, on the energy wear coefficient.
    """

    name = "wear_rate_offset"
    seam = Seam.WEAR
    contacts = kinds.OF_BODIES
    ages = Ageing.NEVER
    signature = "nothing in fresh loops; end hooks and scar volume grow faster or slower"
    remedy = "map the scars again, and fit the wear coefficient to these materials"
    confused_with = ("wear_rate_evolution", "plasticity")
    answers = (
        INTERRUPTED_SCARS.shows("volumes in another proportion to the energy"),
        SCAR_MAPS.shows("other volumes at the modelled lengths"),
        CLEANED_SCARS.shows("the same scars once cleaned"),
    )
    model_error = 0.08

    factor: float = _factor("of both wires", easy=1.5, hard=1.12, least=0.4, most=2.5)

    def changed(self, described: WearRates, _age: Age) -> WearRates:
        return described.scaled(self.factor)


@dataclass(frozen=True)
class WearRateEvolution(Effect[WearRates]):
    """A wear coefficient that changes over the test, exponentially towards a final value.

    Fresh metal wears faster (or slower) than the oxide bed that later carries the load:
    f(n) = f_f + (f_i − f_f) exp(−n/n_c). Infante-García et al., Sensors 20 (2020) 4152, use a variable coefficient
    for the steel wires; running-in is described by Blau, Tribol. Int. 34 (2001) 585.
    """

    name = "wear_rate_evolution"
    seam = Seam.WEAR
    contacts = kinds.OF_BODIES
    ages = Ageing.BY_CYCLES
    signature = "the path of end hooks and volumes over the cycles, not only their end"
    remedy = "stop tests early and map their scars; if wear runs in, state it"
    confused_with = ("wear_rate_offset", "plasticity")
    answers = (
        INTERRUPTED_SCARS.shows("volumes in no constant proportion to the energy"),
        SCAR_MAPS.shows("other volumes at the modelled lengths"),
        OTHER_STROKE.shows("the same course over the cycles"),
    )
    model_error = 0.08

    initial_factor: float = _factor("at the start", easy=3.0, hard=1.5, least=0.2, most=5.0)
    final_factor: float = _factor("in the end", easy=1.0, hard=1.0, least=0.4, most=2.5)
    cycles: float = cycles_of_change("cycles after which 63 % of the change has happened", 1e4)

    steepness: float = form(exponent(0.55))  #: Form of the law, see `Course`, as the next.
    order: float = form(order(0.7))

    def changed(self, described: WearRates, age: Age) -> WearRates:
        return described.scaled(
            Course(self.initial_factor, self.final_factor, self.cycles, self.steepness, self.order).at(age.cycles)
        )


@dataclass(frozen=True)
class ContactOxygenation(Effect[WearRates]):
    """Wear that is small where oxygen does not get.

    Oxygen diffuses in from the contact's edges and is consumed in proportion to the friction power density q. It
    reaches the distance d = √(S/q) from the edge, with the supply S. Farther inside, debris does not oxidise, wear is
    adhesive and its coefficient smaller; over the last 0.3 d, where little oxygen is left, the coefficient changes
    linearly between both. Source: Arnaud, Baydoun and Fouvry, Tribol. Int. 161 (2021) 107077; of 39 tests of titanium,
    those with W-shaped scars have q a² above 0.31 to 0.38 W at Hertz's half-width a (Fouvry et al., Tribol. Int. 113
    (2017) 460).
    """

    name = "contact_oxygenation"
    seam = Seam.WEAR
    ages = Ageing.NEVER
    signature = "the middle of the scar wears too little: a W in place of a U, the more the faster the test"
    remedy = "see whether air reaches the middle of the contact"
    confused_with = ("wear_rate_offset", "third_body")
    answers = (
        LOWER_FREQUENCY.shows("larger volumes at the same energy, and a U-shaped scar"),
        SCAR_MAPS.shows("too little depth in the middle alone"),
        INTERRUPTED_SCARS.shows("volumes that grow with less than the energy as the contact widens"),
    )
    prior_weight = 0.5
    model_error = 0.1
    needs_whole_cycles = True
    # Scars of wires are so narrow that oxygen gets everywhere.
    contacts = (kinds.LINE_CONTACT,)

    supply_W: float = parameter(
        "friction power density times the square of the distance that oxygen gets from the contact's edge",
        Quantity("W", 1e-9, 1e6),
        neutral=None,
        easy=5e-5,
        hard=1.5e-4,
        interest=(1e-5, 10.0),
        logarithmic=True,
    )
    starved_factor: float = parameter(
        "wear coefficient where there is no oxygen over that where there is",
        Quantity("1", 0.0, 1.0),
        neutral=1.0,
        easy=0.2,
        hard=0.6,
        interest=(0.05, 0.8),
        logarithmic=True,
    )

    def changed(self, described: WearRates, _age: Age) -> WearRates:
        if self.starved_factor == 1.0:
            return described
        return replace(described, oxygen=OxygenSupply(self.supply_W, self.starved_factor))

    def predicted(self, chain: Chain) -> Chain:
        return chain if self.starved_factor == 1.0 else chain.with_oxygen(self.supply_W, self.starved_factor)
