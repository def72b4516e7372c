"""Third body: debris that stays in the scars carries the load."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from solvers import RoughLayer, ThirdBody
from wirewear.base.quantity import Quantity
from wirewear.effects.chain import Chain
from wirewear.effects.effect import Effect
from wirewear.effects.measurements import CLEANED_SCARS, EARLY_LOOPS, ENCODER, HALF_LOAD, LOWER_FREQUENCY, SECOND_HEIGHT
from wirewear.effects.parameter import added, exponent, form, limit_um, parameter, part
from wirewear.effects.seams import Age, ContactLaw, Seam

# Shear modulus over the modulus of a laterally confined bed, (1 − 2ν)/(2(1 − ν)) at ν = 0.3.
_SHEAR_TO_CONFINED = 0.286

# Part of the bed's compliance that the full simulation shows (40 % retained, 500 MPa): it spreads the contact.
_SPREADING = 0.5

# Square of the scar's area over that of the fresh contact at which beds of another growth shear alike.
_GROWN = 100.0

# A bed that is filled by less than this share of what it holds knows no limit.
_NO_LIMIT = 1e-9


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
    answers = (
        SECOND_HEIGHT.shows("both points move alike"),
        ENCODER.shows("less of the stroke reaches the contact"),
        HALF_LOAD.shows("a stick branch that is softer at half the load"),
        LOWER_FREQUENCY.shows("the soft branch stays"),
        EARLY_LOOPS.shows("the stick branch softens"),
        CLEANED_SCARS.shows("deeper scars once cleaned"),
    )
    model_error = 0.12

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

    # Not found: a bed that is full from the start is a spring.
    filling: float = form(exponent(0.6), found=False)
    # A line contact's bed is computed along its profile, and stays a share of the depth: it has neither of these. Even
    # beds and gathered ones shear by V^0.2 more as they wear (contacts smaller than the scar), ejected ones less.
    growth: float = form(added("power of the worn volume in the bed's shear", -0.2, 0.4), contacts=("crossed-wires",))
    full_um: float = form(limit_um(0.5, 200.0), contacts=("crossed-wires",))
    spreading: float = form(part("of its give that spreads the pressure", -0.5, 1.5), contacts=("crossed-wires",))

    def changed(self, described: ContactLaw, _age: Age) -> ContactLaw:
        """The law with the bed."""
        if self.retained_fraction == 0.0:
            return described
        return replace(described, layers=(*described.layers, ThirdBody(self.retained_fraction, self.modulus_MPa)))

    def foreseen(self, chain: Chain) -> Chain:
        """Scars that are filled, and a spring: a bed of f·V/A on the area A shears by f V/(A² G) per newton.

        A² = πRV of wires once the scar is larger than Hertz's contact. A bed that fills later has a power of it. One
        that is full at a thickness h_f has h_f (1 − exp(−f V/(A h_f))), and what comes on top is ejected. A bed also
        spreads the pressure: as a rough layer does that gives way as much, h p/M, under the mean pressure p.
        """
        shear_N_per_um2 = 1e-6 * _SHEAR_TO_CONFINED * self.modulus_MPa
        scar2_um4 = chain.worn_area2_um4
        per_area2 = np.divide(chain.worn_um3, scar2_um4, out=np.zeros_like(scar2_um4), where=scar2_um4 > 0.0)
        depth_um = per_area2 * np.sqrt(scar2_um4)
        retained = self.retained_fraction * _kept(self.retained_fraction * depth_um / self.full_um)
        scars = scar2_um4 / chain.fresh_area_um2**2
        largest = _SPREADING * retained * per_area2 / shear_N_per_um2
        shear = largest * (scars / (scars + 1.0)) ** self.filling * ((scars + 1.0) / _GROWN) ** self.growth
        return replace(
            chain,
            retained_fraction=chain.retained_fraction + retained,
            bed_MPa=np.full_like(chain.bed_MPa, self.modulus_MPa) if self.retained_fraction > 0.0 else chain.bed_MPa,
            compliance_um_per_N=chain.compliance_um_per_N + shear,
            bed_um=chain.bed_um + self.spreading * self._as_rough_um(chain, retained * depth_um),
        )

    def _as_rough_um(self, chain: Chain, thickness_um: NDArray[np.float64]) -> NDArray[np.float64]:
        """Height (n,) of the rough layer that gives way like a bed of thicknesses (n,) under the mean pressure."""
        pressure_MPa = 1e6 * chain.load_N / (np.sqrt(chain.worn_area2_um4) + chain.fresh_area_um2)
        closure, _ = RoughLayer(1.0).closure(pressure_MPa, chain.worn_um3)
        return np.asarray(thickness_um * pressure_MPa / self.modulus_MPa / closure)


def _kept(thickness: NDArray[np.float64]) -> NDArray[np.float64]:
    """Share of what would be kept of debris that lies so many times as thick as a full bed, (n,)."""
    return np.divide(-np.expm1(-thickness), thickness, out=np.ones_like(thickness), where=thickness > _NO_LIMIT)
