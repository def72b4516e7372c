"""Causes of the withheld set at the seams of a finite element run; what is read of a run alone is an instrument.

They take the same laws over the cycles as the independent model does: `ageing` and `film`.
"""

from dataclasses import dataclass, replace
from typing import Any

from solvers import Holder
from studies.blind.generators.ageing import Film, Growth, Hanging, Shedding, Steps, Swing
from studies.blind.generators.finite_element.numbers import cycles_of, micrometres, number
from wirewear.effects import Age, ContactLaw, Effect, Loading, Seam


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


@dataclass(frozen=True)
class CrackingFlexure(Effect[Holder]):
    """A fatigue crack grows through a leaf of the holder, which gives way ever faster: c (n/n_e)^p in series."""

    name = "cracking_flexure"
    seam = Seam.HOLDER
    signature = "loops lean late in the test, and ever faster"
    confused_with = ()

    um_per_N: float = micrometres("compliance of the cracked leaf in the end", "um_per_N")
    cycles: float = cycles_of("cycle at which it has come so far")
    power: float = number("power of the cycles with which it comes on", 0.1, 50.0)

    def changed(self, described: Holder, age: Age) -> Holder:
        """The holder with what the crack gives by that cycle."""
        cracked = Growth(1e-3 * self.um_per_N, self.cycles, self.power).at(age.cycles)
        return replace(described, tangential_compliance_mm_per_N=described.tangential_compliance_mm_per_N + cracked)


@dataclass(frozen=True)
class WearingPivot(Effect[Holder]):
    """The pin of the holder's pivot wears evenly with the cycles, and its play grows from none."""

    name = "wearing_pivot"
    seam = Seam.HOLDER
    signature = "a shelf at no force that widens over the test"
    confused_with = ()

    gap_um: float = micrometres("width of the play in the end")
    cycles: float = cycles_of("cycle at which it is so wide")

    def changed(self, described: Holder, age: Age) -> Holder:
        """The holder with the play of that cycle added to its own."""
        return replace(described, play_mm=described.play_mm + Growth(1e-3 * self.gap_um, self.cycles).at(age.cycles))


@dataclass(frozen=True)
class SheddingFilm(Effect[ContactLaw]):
    """A film of transferred metal builds up and is shed at once, again and again."""

    name = "shedding_film"
    seam = Seam.CONTACT
    signature = "the loop's height is a sawtooth over the cycles"
    confused_with = ()

    share: float = number("relative change of the friction before the film is shed", -0.9, 5.0)
    cycles: float = cycles_of("cycles from one shedding to the next")

    def changed(self, described: ContactLaw, age: Age) -> ContactLaw:
        """The law with the friction on the film of that cycle."""
        return replace(described, friction=described.friction * Shedding(self.share, self.cycles).at(age.cycles))


@dataclass(frozen=True)
class ChangingAir(Effect[ContactLaw]):
    """Humidity changes at three moments, and friction with it."""

    name = "changing_air"
    seam = Seam.CONTACT
    signature = "the loop's height takes three steps"
    confused_with = ()

    factor_1: float = number("friction after the first change over that before all", 0.1, 10.0)
    factor_2: float = number("friction after the second change over that before all", 0.1, 10.0)
    factor_3: float = number("friction after the third change over that before all", 0.1, 10.0)
    cycle_1: float = cycles_of("cycle of the first change")
    cycle_2: float = cycles_of("cycle of the second change")
    cycle_3: float = cycles_of("cycle of the third change")

    def changed(self, described: ContactLaw, age: Age) -> ContactLaw:
        """The law with the friction in the air of that cycle."""
        taken = ((self.cycle_1, self.factor_1), (self.cycle_2, self.factor_2), (self.cycle_3, self.factor_3))
        return replace(described, friction=described.friction * Steps(taken).at(age.cycles))


@dataclass(frozen=True)
class SwingingLoad(Effect[Loading]):
    """The frame grows and shrinks with the temperature of the room against the loading spring."""

    name = "swinging_load"
    seam = Seam.LOADING
    signature = "forces swing evenly over the cycles"
    confused_with = ()

    share: float = number("largest relative change of the load", 0.0, 0.9)
    cycles: float = cycles_of("cycles of one swing")
    phase_rad: float = number("phase of the swing at the start", -10.0, 10.0)

    def changed(self, described: Loading, age: Age) -> Loading:
        """The loading with the load of that cycle."""
        swing = Swing(self.share, self.cycles, self.phase_rad)
        return replace(described, normal_load_N=swing.at(age.cycles) * described.normal_load_N)


@dataclass(frozen=True)
class IncubatedWear(Effect[Any]):
    """A hard coat or oxide wears hardly until it is broken, and the wires as stated afterwards."""

    name = "incubated_wear"
    seam = Seam.WEAR
    signature = "the scar is shallow, the more so early in the test"
    confused_with = ()

    share: float = number("of the wear that the coat keeps off", 0.0, 0.999)
    cycle: float = cycles_of("cycle at which half of the coat is gone")
    abruptness: float = number("power of the cycles with which the coat goes", 0.5, 50.0)

    def changed(self, described: Any, age: Age) -> Any:
        """The rates through what is left of the coat."""
        return described.scaled(Film(self.share, self.cycle, self.abruptness).at(age.cycles))


#: By name, in the order in which they are drawn.
WITHHELD: dict[str, type[Effect[Any]]] = {
    effect.name: effect
    for effect in (CrackingFlexure, WearingPivot, SheddingFilm, ChangingAir, SwingingLoad, IncubatedWear)
}
