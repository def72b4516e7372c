"""Causes of the reserved set at the seams of a finite element run; what is read of a run alone is an instrument."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from studies.blind.generators.ageing import Hanging
from studies.blind.generators.finite_element.numbers import cycles_of, number
from wirewear.effects import Age, Effect, Loading, Seam


@dataclass(frozen=True)
class StickingSlide(Effect[Loading]):
    """The upright slide of the load sticks while the wires sink away from it, and slips after them now and then."""

    name = "sticking_slide"
    seam = Seam.LOADING
    signature = "both forces fall and are whole again at once, ever more seldom"
    confused_with = ()

    loss: float = number("share of the load that is lost before the slide slips", 0.0, 0.95)
    cycles: float = cycles_of("cycle at which it slips for the first time")

    def changed(self, described: Loading, age: Age) -> Loading:
        """The loading with the load of that cycle."""
        left = Hanging(self.loss, self.cycles).at(age.cycles)
        return replace(described, normal_load_N=left * described.normal_load_N)


#: By name, in the order in which they are drawn.
RESERVED: dict[str, type[Effect[Any]]] = {effect.name: effect for effect in (StickingSlide,)}
