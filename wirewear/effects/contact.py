"""Effects between the surfaces: a different or changing coefficient of friction, and compliant layers."""

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from geometry.arrays import Array
from solvers import DebrisFlow, RoughLayer, ThirdBody
from solvers.laws.debris import staying
from wirewear.base import kinds
from wirewear.base.course import Course
from wirewear.base.units import Quantity
from wirewear.effects import measurements
from wirewear.effects.effect import Chain, Effect
from wirewear.effects.parameter import added, cycles_of_change, exponent, form, limit_um, order, parameter, part, share
from wirewear.effects.seams import Age, Ageing, ContactLaw, Seam

# Part of the bed's compliance that the full simulation shows (40 % retained, 500 MPa): it spreads the contact.
_SPREADING = 0.5


def _friction(meaning: str, *, easy: float, hard: float, least: float, most: float) -> float:
    quantity, stated = Quantity("1", 0.0, 2.0), "contact.friction"
    interest = (least, most)
    return parameter(
        meaning, quantity, neutral=1.0, easy=easy, hard=hard, interest=interest, logarithmic=True, share_of=stated
    )


@dataclass(frozen=True)
class FrictionOffset(Effect[ContactLaw]):
    """Another coefficient of friction, constant over the test.

    Coulomb friction with a coefficient other than the stated one: plateau and knee move together, at every cycle. The
    usual estimate from the largest force is too high in deep scars; see Fouvry, Duó & Perruchaut, Wear 257 (2004) 916,
    and the geometry-independent coefficient of Infante-García et al., Sensors 20 (2020) 4152.
    """

    name = "friction_offset"
    seam = Seam.CONTACT
    ages = Ageing.NEVER
    signature = "height and knee of the loop move together, at all cycles"
    remedy = "calibrate normal load and force; if both are right, state this friction"
    confused_with = ("normal_load_drift", "friction_evolution")
    answers = (
        measurements.NORMAL_FORCE.shows("as modelled, under friction that is off throughout"),
        measurements.HALF_LOAD.shows("half the height at half the load"),
        measurements.LOWER_FREQUENCY.shows("friction and wear stay"),
        measurements.INTERRUPTED_SCARS.shows("volumes that follow the measured energy"),
        measurements.SCAR_MAPS.shows("volumes that follow the measured energy"),
    )

    friction: float = _friction("true coefficient of friction", easy=0.85, hard=0.96, least=0.75, most=1.3)

    def changed(self, described: ContactLaw, _age: Age) -> ContactLaw:
        return replace(described, friction=self.friction)


@dataclass(frozen=True)
class FrictionEvolution(Effect[ContactLaw]):
    """Friction that changes over the test, exponentially towards a final value.

    Running-in strips oxide and contaminants, then oxidised debris builds up: µ(n) = µ_f + (µ_i − µ_f) exp(−n/n_c).
    Source: Blau, Tribol. Int. 34 (2001) 585, on running-in and friction over time.
    """

    name = "friction_evolution"
    seam = Seam.CONTACT
    ages = Ageing.BY_CYCLES
    signature = "the loop's height drifts over the cycles, not tied to the worn depth"
    remedy = "clean specimens alike; if friction runs in, state it"
    confused_with = ("normal_load_drift", "friction_offset")
    answers = (
        measurements.NORMAL_FORCE.shows("as modelled, under friction that changes"),
        measurements.INTERRUPTED_SCARS.shows("volumes that follow the measured energy"),
        measurements.EARLY_LOOPS.shows("only the height changes"),
        measurements.OTHER_STROKE.shows("the same course over the cycles"),
        measurements.LOWER_FREQUENCY.shows("friction and wear stay"),
    )
    # What its forms leave of ten laws over three decades, in the mean square: 2 % (0 to 3.4 %).
    model_error = 0.03

    initial: float = _friction("coefficient of friction at the start", easy=0.7, hard=0.93, least=0.4, most=1.5)
    final: float = _friction("coefficient of friction in the end", easy=1.0, hard=1.0, least=0.75, most=1.3)
    cycles: float = cycles_of_change("cycles after which 63 % of the change has happened", 3000.0)

    steepness: float = form(exponent(0.55))  #: Form of the law, see `Course`, as the next.
    order: float = form(order(0.7))

    def changed(self, described: ContactLaw, age: Age) -> ContactLaw:
        course = Course(self.initial, self.final, self.cycles, self.steepness, self.order)
        return replace(described, friction=course.at(age.cycles))


@dataclass(frozen=True)
class RoughnessCompliance(Effect[ContactLaw]):
    """Asperities that give way before they are worn in.

    Asperities of exponentially distributed heights close by s ln(1 + p/p_c) under the pressure p, with p_c = 100 MPa,
    and shear 1.21 times as easily (Mindlin): a soft stick branch that stiffens with the load. Their height falls as
    they wear in, s(n) = s exp(−n/n_c). Source: Greenwood & Williamson, Proc. R. Soc. A 295 (1966) 300.
    """

    name = "roughness_compliance"
    seam = Seam.CONTACT
    contacts = kinds.OF_BODIES
    ages = Ageing.BY_CYCLES
    signature = "a soft stick branch early on that vanishes as it wears in and stiffens with the load"
    remedy = "measure the roughness of fresh specimens, or run them in before you measure"
    confused_with = ("tangential_compliance", "third_body")
    answers = (
        measurements.SECOND_HEIGHT.shows("both points move alike"),
        measurements.ENCODER.shows("less of the stroke reaches the contact"),
        measurements.HALF_LOAD.shows("a stick branch that is softer at half the load"),
        measurements.LOWER_FREQUENCY.shows("the soft branch stays"),
        measurements.EARLY_LOOPS.shows("the stick branch stiffens"),
    )
    model_error = 0.08

    layer_um: float = parameter(
        "closure that raises the pressure e-fold, about the standard deviation of the asperities' heights",
        Quantity("um", 0.0, 20.0),
        neutral=0.0,
        easy=1.0,
        hard=0.2,
        interest=(0.05, 3.0),
        logarithmic=True,
    )
    cycles: float = cycles_of_change("cycles over which the asperities wear to 37 % of their height", 3000.0)

    steepness: float = form(exponent(0.55))  #: Form of the law, see `Course`, as the next two.
    order: float = form(order(0.7))
    lasting: float = form(share(0.005, 0.6))
    spreading: float = form(part("of its height that spreads the pressure", -0.5, 1.5), contacts=kinds.AT_A_POINT)

    def changed(self, described: ContactLaw, age: Age) -> ContactLaw:
        height_um = self._height_um.at(age.cycles)
        # Of a rough layer that has worn in, less than this share is as good as none.
        if height_um <= 1e-6 * self.layer_um:
            return described
        return replace(described, layers=(*described.layers, RoughLayer(1e-3 * height_um)))

    def predicted(self, chain: Chain) -> Chain:
        """The chain with a compliance of 1.21 s/P added: asperities that close by s ln p under the pressure p, with
        their present height s, give way by s/P per N at the load P. They also spread the pressure.
        """
        height_um = self._height_um.at(chain.cycles)
        # Mindlin: tangential over normal compliance of a rough interface, (2 − ν)/(2(1 − ν)) at ν = 0.3.
        added = 1.21 * height_um / chain.load_N
        return replace(
            chain,
            compliance_um_per_N=chain.compliance_um_per_N + added,
            rough_um=chain.rough_um + self.spreading * height_um,
        )

    @property
    def _height_um(self) -> Course:
        return Course(self.layer_um, 0.0, self.cycles, self.steepness, self.order, self.lasting)


def _retained(meaning: str, held_by: tuple[str, float] | None = None) -> float:
    quantity, ends = Quantity("1", 0.0, 0.95), (0.02, 0.7)
    return parameter(
        meaning, quantity, neutral=0.0, easy=0.4, hard=0.1, interest=ends, logarithmic=True, held_by=held_by
    )


def _modulus_of_bed(easy: float) -> float:
    meaning, quantity, ends = "modulus of the laterally confined bed", Quantity("MPa", 1.0, 1e6), (100.0, 5e4)
    return parameter(meaning, quantity, neutral=None, easy=easy, hard=2000.0, interest=ends, logarithmic=True)


@dataclass(frozen=True)
class ThirdBodyLayer(Effect[ContactLaw]):
    """Debris that stays in both scars as an elastic bed and carries the load.

    Debris fills a share f of each wire's worn depth, so that the gap opens by the share 1 − f only; the bed of
    thickness h = f·depth closes by h p/M and shears by h q/G. Source: Godet, Wear 100 (1984) 437; Berthier, Vincent &
    Godet, Wear 125 (1988) 25.
    """

    name = "third_body"
    seam = Seam.CONTACT
    contacts = kinds.OF_BODIES
    signature = "a soft stick branch that grows with the cycles; hooks smaller than the worn depth would give"
    remedy = "look at the debris in and around the scars before they are cleaned"
    confused_with = ("roughness_compliance", "wear_rate_offset", "tangential_compliance")
    answers = (
        measurements.SECOND_HEIGHT.shows("both points move alike"),
        measurements.ENCODER.shows("less of the stroke reaches the contact"),
        measurements.HALF_LOAD.shows("a stick branch that is softer at half the load"),
        measurements.LOWER_FREQUENCY.shows("the soft branch stays"),
        measurements.EARLY_LOOPS.shows("the stick branch softens"),
        measurements.CLEANED_SCARS.shows("deeper scars once cleaned"),
    )
    model_error = 0.12

    retained_fraction: float = _retained("share of the worn depth that debris fills")
    modulus_MPa: float = _modulus_of_bed(500.0)

    # A line contact's bed is computed along its profile, and stays a share of the depth: it has neither of these. Even
    # beds and gathered ones shear by V^0.2 more as they wear (contacts smaller than the scar), ejected ones less.
    growth: float = form(added("power of the worn volume in the bed's shear", -0.2, 0.4), contacts=kinds.AT_A_POINT)
    full_um: float = form(limit_um(0.5, 200.0), contacts=kinds.AT_A_POINT)  #: Largest thickness of the bed.
    spreading: float = form(part("of its give that spreads the pressure", -0.5, 1.5), contacts=kinds.AT_A_POINT)

    def changed(self, described: ContactLaw, _age: Age) -> ContactLaw:
        if self.retained_fraction == 0.0:
            return described
        return replace(described, layers=(*described.layers, ThirdBody(self.retained_fraction, self.modulus_MPa)))

    def predicted(self, chain: Chain) -> Chain:
        """The chain with a bed of debris in the scars.

        Of the worn volume V (µm³) the share f, `retained_fraction`, stays on the worn area A (µm²): the bed is h = f
        V/A thick and shears by h/(A G) µm per N, with its shear modulus G. A² is πRV for wires of radius R once the
        scar is larger than Hertz's contact. `growth`: the shear is multiplied by that power of A². `full_um`, h_f: the
        bed tends to it, h = h_f (1 − exp(−f V/(A h_f))), and further debris is ejected. `spreading`: a bed also spreads
        the pressure, like a rough layer that closes by as much, h p/M, under the mean pressure p; M is `modulus_MPa`.
        """
        return self.limited_to(self.full_um, chain)

    def limited_to(self, full_um: float | Array, chain: Chain) -> Chain:
        """The chain as `predicted` says, with the thickness in µm at which the bed is full at each of the n moments."""
        # Shear modulus over the modulus of a laterally confined bed, (1 − 2ν)/(2(1 − ν)) at ν = 0.3.
        shear_N_per_um2 = 1e-6 * 0.286 * self.modulus_MPa
        scar2_um4 = chain.worn_area2_um4
        per_area2 = np.divide(chain.worn_um3, scar2_um4, out=np.zeros_like(scar2_um4), where=scar2_um4 > 0.0)
        depth_um = per_area2 * np.sqrt(scar2_um4)
        # Thickness (n,) of the bed without its limit, over the limit.
        thickness = self.retained_fraction * depth_um / full_um
        retained = self.retained_fraction * staying(thickness)[1]
        scars = scar2_um4 / chain.fresh_area_um2**2
        largest = _SPREADING * retained * per_area2 / shear_N_per_um2
        # Square of the scar's area over that of the fresh contact at which beds of another growth shear alike.
        shear = largest * scars / (scars + 1.0) * ((scars + 1.0) / 100.0) ** self.growth
        # Height (n,) of the rough layer that closes like a bed of thicknesses (n,) under the mean pressure.
        pressure_MPa = 1e6 * chain.load_N / (np.sqrt(chain.worn_area2_um4) + chain.fresh_area_um2)
        closure, _ = RoughLayer(1.0).closure(pressure_MPa, chain.worn_um3)
        return replace(
            chain,
            # Of two beds the second has what the first leaves open.
            retained_fraction=chain.retained_fraction + (1.0 - chain.retained_fraction) * retained,
            bed_MPa=np.full_like(chain.bed_MPa, self.modulus_MPa) if self.retained_fraction > 0.0 else chain.bed_MPa,
            compliance_um_per_N=chain.compliance_um_per_N + shear,
            bed_um=chain.bed_um + self.spreading * retained * depth_um * pressure_MPa / self.modulus_MPa / closure,
        )


@dataclass(frozen=True)
class DebrisBalance(Effect[ContactLaw]):
    """Debris that flows to the contact's edge and leaves, and protects what it covers.

    As for `third_body`, a share f of each body's worn depth becomes debris, a bed of thickness h. It moves towards the
    nearest edge, at a distance d, by a part ε of the slip: over a path s of slip the share ε s/d of it passes that
    distance, so that h settles where source and ejection balance, h = f w d/(ε s) with the worn depth w over that path.
    A bed takes up part of the slip, which wears nothing; 1/(1 + h/h_p) of it wears. So wear is slower the longer the
    contact. Sources: Fillot, Iordanoff and Berthier, Wear 262 (2007) 949 (balance of source and ejection); Godet, Wear
    100 (1984) 437 (protection).
    """

    name = "debris_balance"
    seam = Seam.CONTACT
    # The bed that the fast model computes along the profile of a line contact does not leave.
    contacts = kinds.AT_A_POINT
    ages = Ageing.BY_WEAR
    signature = "wear that is slower the longer the contact; a bed that is thickest in the middle"
    remedy = "look at the debris in and around the scars before they are cleaned"
    confused_with = ("third_body", "wear_rate_evolution")
    answers = (
        measurements.CLEANED_SCARS.shows("deeper scars once cleaned"),
        measurements.EARLY_LOOPS.shows("faster wear while the contact is small"),
    )
    prior_weight = 0.5
    model_error = 0.3
    needs_whole_cycles = True
    # Loops alone show a bed's give, and no more of what fills or leaves it than a spring that changes.
    needs_scars = True

    # What settles goes with the ratio of both.
    retained_fraction: float = _retained(
        "share of the worn depth that becomes debris between the surfaces", ("leaving_share", 1.0)
    )
    modulus_MPa: float = _modulus_of_bed(2000.0)
    leaving_share: float = parameter(
        "part of the slip by which debris moves towards the contact's edge",
        Quantity("1", 0.0, 1e6),
        neutral=None,
        easy=1e-4,
        hard=1e-3,
        interest=(1e-6, 1e-1),
        logarithmic=True,
    )
    protecting_um: float = parameter(
        "thickness of debris that takes up half of the slip",
        Quantity("um", 1e-3, inf),
        neutral=None,
        easy=1.0,
        hard=10.0,
        interest=(0.05, 50.0),
        logarithmic=True,
    )

    def changed(self, described: ContactLaw, age: Age) -> ContactLaw:
        if self.retained_fraction == 0.0:
            return described
        return replace(self._bed.changed(described, age), debris=self._flow)

    def predicted(self, chain: Chain) -> Chain:
        """The chain with a bed as `ThirdBodyLayer` predicts it, limited to the thickness at which source and ejection
        balance at the mean distance from the edge; wear is slower by what the bed protects.
        """
        if self.retained_fraction == 0.0:
            return chain
        path_um = 1e6 * chain.energy_J / (chain.friction * chain.load_N)
        depth_um = chain.worn_um3 / chain.area_um2
        passages = np.maximum(self._flow.passages(path_um, chain.edge_um), 1e-12)
        full_um = self.retained_fraction * depth_um / passages
        bedded = self._bed.limited_to(np.maximum(full_um, 1e-9), chain)
        thickness_um = (bedded.retained_fraction - chain.retained_fraction) * depth_um
        return replace(bedded, wear_um3_per_mJ=chain.wear_um3_per_mJ * self._flow.wearing(1e-3 * thickness_um))

    @property
    def _bed(self) -> ThirdBodyLayer:
        return ThirdBodyLayer(self.retained_fraction, self.modulus_MPa)

    @property
    def _flow(self) -> DebrisFlow:
        return DebrisFlow(self.leaving_share, 1e-3 * self.protecting_um)
