"""Plasticity: the wires flatten before they wear."""

from dataclasses import dataclass, replace

from wirewear.base.quantity import Quantity
from wirewear.effects.effect import Effect
from wirewear.effects.measurements import INTERRUPTED_SCARS
from wirewear.effects.parameter import parameter
from wirewear.effects.seams import Age, Ageing, Seam, Specimens


@dataclass(frozen=True)
class Plasticity(Effect[Specimens]):
    """Wires flattened plastically before any wear.

    Hertz gives the steel wires 4.7 GPa, above what their contact bears elastically (first yield at 1.6 σ_y): within the
    first strokes they flatten until the load spreads. Both wires give way by half the overlap that their unworn shapes
    have at an approach of `flattening_um`, on the moving wire all along the stroke; what is pushed aside is neglected.
    Source: Johnson, Contact Mechanics (1985), ch. 6.
    """

    name = "plasticity"
    seam = Seam.SPECIMENS
    contacts = ("crossed-wires",)
    ages = Ageing.NEVER
    needs_load = True
    signature = "a larger contact before any wear; a depth that wear coefficient times energy does not explain"
    confused_with = ("wear_rate_offset", "wear_rate_evolution")
    answers = (INTERRUPTED_SCARS.shows("scars before any wear"),)
    model_error = 0.2

    flattening_um: float = parameter(
        "approach of the wires by plastic flattening",
        Quantity("um", 0.0, 20.0),
        neutral=0.0,
        easy=2.0,
        hard=0.5,
        interest=(0.1, 4.0),
        logarithmic=True,
    )

    def changed(self, described: Specimens, _age: Age) -> Specimens:
        """Wires flattened by so much more."""
        return replace(described, flattening_mm=described.flattening_mm + 1e-3 * self.flattening_um)
