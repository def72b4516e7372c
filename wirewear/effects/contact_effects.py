"""Effects in the contact law: friction that is not what the model takes it for, and layers between the surfaces."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import exp

from solvers import RoughLayer, ThirdBody
from wirewear.effects.effect import Effect
from wirewear.effects.parameter import parameter
from wirewear.effects.seams import Age, ContactLaw, Seam
from wirewear.quantity import Quantity

# Of a rough layer that has worn in, less than this share is as good as none.
_WORN_AWAY = 1e-6
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


@dataclass(frozen=True)
class RoughnessCompliance(Effect[ContactLaw]):
    """Asperities that give way before they are worn in.

    Asperities of exponentially distributed heights close by s ln(1 + p/p_c) under the pressure p, with p_c = 100 MPa,
    and shear 1.21 times as easily (Mindlin): a soft stick branch that stiffens with the load. Their height falls as
    they wear in, s(n) = s exp(−n/n_c). Source: Greenwood & Williamson, Proc. R. Soc. A 295 (1966) 300.
    """

    name = "roughness_compliance"
    seam = Seam.CONTACT
    signature = "a soft stick branch early on that vanishes as it wears in and stiffens with the load"
    confused_with = ("tangential_compliance", "third_body")
    split_by = "the series of cycles, over which only roughness vanishes; a test at another load"

    layer_um: float = parameter(
        "closure that raises the pressure e-fold, about the standard deviation of the asperities' heights",
        Quantity("um", 0.0, 20.0),
        neutral=0.0,
        easy=1.0,
        hard=0.2,
        interest=(0.05, 3.0),
        logarithmic=True,
    )
    cycles: float = parameter(
        "cycles over which the asperities wear to 37 % of their height",
        Quantity("cycles", 1.0, 1e9),
        neutral=None,
        easy=3000.0,
        hard=3000.0,
        interest=(30.0, 1e5),
        logarithmic=True,
    )

    def changed(self, described: ContactLaw, age: Age) -> ContactLaw:
        """The law with the rough layer as it is at that cycle."""
        left = exp(-age.cycles / self.cycles)
        if self.layer_um == 0.0 or left < _WORN_AWAY:
            return described
        return replace(described, layers=(*described.layers, RoughLayer(1e-3 * self.layer_um * left)))


@dataclass(frozen=True)
class ThirdBodyLayer(Effect[ContactLaw]):
    """Debris that stays in both scars as an elastic bed and carries the load.

    Of each wire's worn depth a share f is filled with debris, so that the gap opens by 1 − f only; the bed of thickness
    h = f·depth gives way by h p/M and shears by h q/G. Source: Godet, Wear 100 (1984) 437; Berthier, Vincent & Godet,
    Wear 125 (1988) 25.
    """

    name = "third_body"
    seam = Seam.CONTACT
    signature = "a soft stick branch that grows with the cycles; hooks smaller than the worn depth would give"
    confused_with = ("roughness_compliance", "wear_rate_offset", "tangential_compliance")
    split_by = "the series of cycles (roughness vanishes, debris grows); scars before and after cleaning"

    retained_fraction: float = parameter(
        "share of the worn depth that debris fills",
        Quantity("1", 0.0, 0.95),
        neutral=0.0,
        easy=0.4,
        hard=0.1,
        interest=(0.02, 0.7),
        logarithmic=True,
    )
    modulus_MPa: float = parameter(
        "modulus of the laterally confined bed",
        Quantity("MPa", 1.0, 1e6),
        neutral=None,
        easy=500.0,
        hard=2000.0,
        interest=(100.0, 5e4),
        logarithmic=True,
    )

    def changed(self, described: ContactLaw, _age: Age) -> ContactLaw:
        """The law with the bed."""
        if self.retained_fraction == 0.0:
            return described
        return replace(described, layers=(*described.layers, ThirdBody(self.retained_fraction, self.modulus_MPa)))
