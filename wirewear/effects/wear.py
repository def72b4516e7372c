"""Effects on the wear coefficient: a different one, one that changes over the test, one that is small without
oxygen.
"""

from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Array
from solvers import Conductor, FrictionHeat, OxygenSupply, WearRates
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
        LOWER_FREQUENCY.shows("friction and wear stay"),
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
        LOWER_FREQUENCY.shows("friction and wear stay"),
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


_WARM_K = 3.0  #: Less warming changes friction by less than 1 %, at the largest effect that is expected.


def _of_conduction(
    meaning: str,
    quantity: Quantity,
    typical: float,
    ends: tuple[float, float],
    default: float | None = None,
    power: float = 0.0,
) -> float:
    """A number of the bodies. power: with which it makes surfaces colder, and whatever follows temperature larger."""
    return parameter(
        meaning,
        quantity,
        neutral=None,
        easy=typical,
        hard=typical,
        interest=ends,
        logarithmic=default != 0.0,
        default=default,
        held_by=("", power),
    )


def _by_temperature(meaning: str, unit: str, easy: float, held_by: tuple[str, float] | None = None) -> float:
    quantity, ends = Quantity(unit, -1e3, 1e3), (-2.0 * easy, 2.0 * easy)
    return parameter(
        meaning, quantity, neutral=0.0, easy=easy, hard=0.2 * easy, interest=ends, default=0.0, held_by=held_by
    )


@dataclass(frozen=True)
class FrictionHeating(Effect[WearRates]):
    """Wear, friction and oxidation that change as friction warms the surfaces.

    The friction power of a cycle warms both surfaces, each a half-space, at each place by its mean and flash
    temperature (Carslaw and Jaeger, Conduction of Heat in Solids, 1959, ch. X; Blok, 1937). The wear coefficient and
    the consumption of oxygen follow Arrhenius' law from 20 °C on, friction a straight line.
    """

    name = "friction_heat"
    seam = Seam.WEAR
    contacts = kinds.OF_BODIES
    ages = Ageing.BY_WEAR
    signature = "wear or friction that changes with the frequency, and with the contact's size as it wears"
    remedy = "measure a temperature beside the contact, or test at a lower frequency"
    confused_with = (
        "friction_evolution", "wear_rate_evolution", "wear_rate_offset", "friction_offset", "contact_oxygenation",
    )  # fmt: skip
    answers = (
        LOWER_FREQUENCY.shows("wear and friction of cold surfaces"),
        SCAR_MAPS.shows("other volumes at the modelled lengths"),
    )
    prior_weight = 0.5
    model_error = 0.3
    needs_whole_cycles = True

    conductivity_W_per_m_K: float = _of_conduction(
        "thermal conductivity of the driven body", Quantity("W_per_m_K", 1e-3, 1e4), 46.0, (1.0, 400.0), power=1.0
    )
    heat_capacity_J_per_cm3_K: float = _of_conduction(
        "heat capacity of both bodies", Quantity("J_per_cm3_K", 1e-3, 1e3), 3.6, (1.5, 4.0)
    )
    held_over_driven: float = _of_conduction(
        "conductivity of the held body over that of the driven one", Quantity("1", 1e-4, 1e4), 1.0, (0.1, 10.0), 1.0
    )
    resistance_K_per_W: float = _of_conduction(
        "resistance of either body to its surroundings", Quantity("K_per_W", 0.0, 1e9), 20.0, (0.0, 100.0), 0.0
    )
    line_length_mm: float = _of_conduction(
        "length of a line contact", Quantity("mm", 1e-3, 1e5), 10.0, (1.0, 100.0), 1.0
    )
    wear_kJ_per_mol: float = _by_temperature("activation energy of the wear coefficient", "kJ_per_mol", 20.0)
    oxidation_kJ_per_mol: float = _by_temperature(
        "activation energy of the consumption of oxygen", "kJ_per_mol", 20.0, ("", 0.0)
    )
    friction_per_K: float = _by_temperature("change of the coefficient of friction, over it, per kelvin", "per_K", 1e-3)

    def changed(self, described: WearRates, _age: Age) -> WearRates:
        if not (self.wear_kJ_per_mol or self.oxidation_kJ_per_mol or self.friction_per_K):
            return described
        return replace(described, heat=self._heat)

    def predicted(self, chain: Chain) -> Chain:
        """The chain with wear, friction and supply of oxygen at the mean temperature of the evenly heated contact."""
        if not (self.wear_kJ_per_mol or self.oxidation_kJ_per_mol or self.friction_per_K):
            return chain
        heat, rise = self._heat, self._rise_K(chain)
        return replace(
            chain,
            wear_um3_per_mJ=chain.wear_um3_per_mJ * heat.wearing(rise),
            friction=chain.friction * heat.friction_factor(rise),
            oxygen_W=chain.oxygen_W / heat.oxidising(rise),
        )

    def may_show(self, chain: Chain) -> bool:
        """False where the surfaces hardly warm."""
        return bool(np.mean(self._rise_K(chain)) > _WARM_K)

    def _rise_K(self, chain: Chain) -> Array:
        """(n,) mean rise of the temperature of both surfaces by the friction power."""
        power_W = chain.frequency_Hz * np.abs(np.gradient(chain.energy_J, chain.cycles)) if chain.cycles.size > 1 else 0
        per_W = 1e6 * chain.warming_per_um
        ways = (
            per_W / one.conductivity_W_per_m_K + one.resistance_K_per_W for one in (self._heat.upper, self._heat.lower)
        )
        return np.asarray(power_W / sum(1.0 / way for way in ways))

    @property
    def _heat(self) -> FrictionHeat:
        driven = Conductor(self.conductivity_W_per_m_K, self.heat_capacity_J_per_cm3_K, self.resistance_K_per_W)
        held = replace(driven, conductivity_W_per_m_K=self.held_over_driven * self.conductivity_W_per_m_K)
        return FrictionHeat(
            upper=held,
            lower=driven,
            wear_J_per_mol=1e3 * self.wear_kJ_per_mol,
            oxidation_J_per_mol=1e3 * self.oxidation_kJ_per_mol,
            friction_per_K=self.friction_per_K,
            length_mm=self.line_length_mm,
        )
