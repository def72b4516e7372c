"""Effects in the wear law: a rate that is not the stated one, or not constant."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp

from solvers import WearRates
from wirewear.effects.effect import Effect
from wirewear.effects.parameter import parameter
from wirewear.effects.seams import Age, Seam
from wirewear.quantity import Quantity

_FACTOR = Quantity("1", 0.0, 100.0)


@dataclass(frozen=True)
class WearRateOffset(Effect[WearRates]):
    """Another wear coefficient, constant over the test.

    Coefficients of one pair of materials differ by tens of per cent between rigs and laboratories, because debris
    leaves the contact differently. Source: Fouvry et al., Wear 255 (2003) 287, on the energy wear coefficient.
    """

    name = "wear_rate_offset"
    seam = Seam.WEAR
    signature = "nothing in fresh loops; end hooks and scar volume grow faster or slower"
    confused_with = ("wear_rate_evolution", "plasticity")
    split_by = "scars of interrupted tests"

    factor: float = parameter(
        "factor on the wear coefficient of both wires",
        _FACTOR,
        neutral=1.0,
        easy=1.5,
        hard=1.12,
        interest=(0.4, 2.5),
        logarithmic=True,
    )

    def changed(self, described: WearRates, _age: Age) -> WearRates:
        """The rates times the factor."""
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
    signature = "the path of end hooks and volumes over the cycles, not only their end"
    confused_with = ("wear_rate_offset", "plasticity")
    split_by = "scars of interrupted tests; loops between first and last"

    initial_factor: float = parameter(
        "factor on the wear coefficient at the start",
        _FACTOR,
        neutral=1.0,
        easy=3.0,
        hard=1.5,
        interest=(0.2, 5.0),
        logarithmic=True,
    )
    final_factor: float = parameter(
        "factor on the wear coefficient in the end",
        _FACTOR,
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

    def changed(self, described: WearRates, age: Age) -> WearRates:
        """The rates times the factor of that cycle."""
        gone = exp(-age.cycles / self.cycles)
        return described.scaled(self.final_factor + (self.initial_factor - self.final_factor) * gone)
