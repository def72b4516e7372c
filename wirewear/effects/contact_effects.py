"""Effects in the contact law: friction that is not what the model takes it for."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import exp

from wirewear.effects.effect import Effect
from wirewear.effects.parameter import parameter
from wirewear.effects.seams import Age, ContactLaw, Seam
from wirewear.study.quantity import Quantity

_FRICTION = Quantity("1", 0.0, 2.0)


@dataclass(frozen=True)
class FrictionOffset(Effect[ContactLaw]):
    """Another coefficient of friction, constant over the test.

    Coulomb friction with a coefficient other than the stated one: plateau and knee move together, at every cycle. The
    usual estimate from the largest force is too high in deep scars; see Fouvry, Duó & Perruchaut, Wear 257 (2004) 916,
    and the geometry-independent coefficient of Infante-García et al., Sensors 20 (2020) 4152.
    """

    name = "friction_offset"
    seam = Seam.CONTACT
    signature = "height and knee of the loop move together, at all cycles"
    confused_with = ("normal_load_drift", "friction_evolution")
    split_by = "the measured normal force; a test at another load"

    friction: float = parameter(
        "true coefficient of friction",
        _FRICTION,
        neutral=1.0,
        easy=0.85,
        hard=0.96,
        interest=(0.75, 1.3),
        logarithmic=True,
        share_of="contact.friction",
    )

    def changed(self, described: ContactLaw, _age: Age) -> ContactLaw:
        """The law with the true coefficient."""
        return replace(described, friction=self.friction)


@dataclass(frozen=True)
class FrictionEvolution(Effect[ContactLaw]):
    """Friction that changes over the test, exponentially towards a final value.

    Running-in strips oxide and contaminants, then oxidised debris builds up: µ(n) = µ_f + (µ_i − µ_f) exp(−n/n_c).
    Source: Blau, Tribol. Int. 34 (2001) 585, on running-in and friction over time.
    """

    name = "friction_evolution"
    seam = Seam.CONTACT
    signature = "the loop's height drifts over the cycles, not tied to the worn depth"
    confused_with = ("normal_load_drift", "friction_offset")
    split_by = "the measured normal force"

    initial: float = parameter(
        "coefficient of friction at the start",
        _FRICTION,
        neutral=1.0,
        easy=0.7,
        hard=0.93,
        interest=(0.4, 1.5),
        logarithmic=True,
        share_of="contact.friction",
    )
    final: float = parameter(
        "coefficient of friction in the end",
        _FRICTION,
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

    def changed(self, described: ContactLaw, age: Age) -> ContactLaw:
        """The law with the coefficient of that cycle."""
        gone = exp(-age.cycles / self.cycles)
        return replace(described, friction=self.final + (self.initial - self.final) * gone)
