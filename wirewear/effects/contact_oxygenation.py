"""Contact oxygenation: oxygen does not reach the middle of the contact, where wear is adhesive and small."""

from dataclasses import dataclass, replace

import numpy as np

from solvers import OxygenSupply, WearRates
from wirewear.base.quantity import Quantity
from wirewear.effects.chain import Chain
from wirewear.effects.effect import Effect
from wirewear.effects.measurements import INTERRUPTED_SCARS, LOWER_FREQUENCY, SCAR_MAPS
from wirewear.effects.parameter import parameter
from wirewear.effects.seams import Age, Ageing, Seam


@dataclass(frozen=True)
class ContactOxygenation(Effect[WearRates]):
    """Wear that is small where oxygen does not get.

    Oxygen diffuses in from the contact's edges and is used up in proportion to the friction power density q. It gets as
    far as d = √(S/q); S is the supply. Beyond, debris does not oxidise, wear is adhesive and its coefficient smaller.
    Source: Arnaud, Baydoun and Fouvry, Tribol. Int. 161 (2021) 107077; of 39 tests of titanium, those with W-shaped
    scars have q a² above 0.31 to 0.38 W at Hertz's half-width a (Fouvry et al., Tribol. Int. 113 (2017) 460).
    """

    name = "contact_oxygenation"
    seam = Seam.WEAR
    ages = Ageing.NEVER
    signature = "the middle of the scar wears too little: a W in place of a U, the more the faster the test"
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
    contacts = ("line-contact",)

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
        """The rates with that supply of oxygen."""
        if self.starved_factor == 1.0:
            return described
        return replace(described, oxygen=OxygenSupply(self.supply_W, self.starved_factor, described.frequency_Hz))

    def foreseen(self, chain: Chain) -> Chain:
        """The chain with that supply; in the scars of wires oxygen gets everywhere."""
        if chain.length_um == 0.0 or self.starved_factor == 1.0:
            return chain
        supply, factor = (np.full_like(chain.cycles, one) for one in (self.supply_W, self.starved_factor))
        return replace(chain, oxygen_W=supply, starved_factor=factor)
