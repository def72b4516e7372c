"""Wear rate offset: the wear coefficient is another one throughout."""

from dataclasses import dataclass

from solvers import WearRates
from wirewear.base.quantity import Quantity
from wirewear.effects.effect import Effect
from wirewear.effects.measurements import CLEANED_SCARS, INTERRUPTED_SCARS, SCAR_MAPS
from wirewear.effects.parameter import parameter
from wirewear.effects.seams import Age, Ageing, Seam


@dataclass(frozen=True)
class WearRateOffset(Effect[WearRates]):
    """Another wear coefficient, constant over the test.

    Coefficients of one pair of materials differ by tens of per cent between rigs and laboratories, because debris
    leaves the contact differently. Source: Fouvry et al., Wear 255 (2003) 287, on the energy wear coefficient.
    """

    name = "wear_rate_offset"
    seam = Seam.WEAR
    ages = Ageing.NEVER
    signature = "nothing in fresh loops; end hooks and scar volume grow faster or slower"
    confused_with = ("wear_rate_evolution", "plasticity")
    answers = (
        INTERRUPTED_SCARS.shows("volumes in another proportion to the energy"),
        SCAR_MAPS.shows("other volumes at the modelled lengths"),
        CLEANED_SCARS.shows("the same scars once cleaned"),
    )
    model_error = 0.08

    factor: float = parameter(
        "factor on the wear coefficient of both wires",
        Quantity("1", 0.0, 100.0),
        neutral=1.0,
        easy=1.5,
        hard=1.12,
        interest=(0.4, 2.5),
        logarithmic=True,
    )

    def changed(self, described: WearRates, _age: Age) -> WearRates:
        """The rates times the factor."""
        return described.scaled(self.factor)
