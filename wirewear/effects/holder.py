"""Effects of the rig: its springs, free play, angles and load, wires flattened when mounted, and what the drive
holds.
"""

from dataclasses import dataclass, replace
from math import inf, pi, radians, sqrt

from solvers import Holder
from wirewear.base import kinds
from wirewear.base.units import Quantity
from wirewear.effects import measurements
from wirewear.effects.effect import Chain, Effect
from wirewear.effects.parameter import RIGID, parameter
from wirewear.effects.seams import Age, Ageing, Control, Loading, Seam, Specimens
from wirewear.reference import kept_approach


@dataclass(frozen=True)
class TangentialCompliance(Effect[Holder]):
    """A further spring along the motion, in series with the rig.

    Whatever lies between the fixed wire and the point where displacement is measured (clamps, arm, load cell) yields
    by Q/K. In stick, the slopes add as 1/K_m = 1/K_s + 1/K_c + 1/K; in gross slip the slip amplitude falls by µP/K
    and the dissipated energy by 4(µP)²/K. Source: Infante-García et al., Sensors 20 (2020) 4152.
    """

    name = "tangential_compliance"
    seam = Seam.HOLDER
    ages = Ageing.NEVER
    signature = "stick branches lean, height unchanged, displacement error ∝ Q; slip and energy fall"
    remedy = "stiffen clamps and arm, measure displacement nearer the contact, or state the rig's stiffness"
    confused_with = ("rotational_compliance", "displacement_load_coupling")
    answers = (
        measurements.SECOND_HEIGHT.shows("both points move alike"),
        measurements.ENCODER.shows("less of the stroke reaches the contact"),
        measurements.HALF_LOAD.shows("a lean of the same slope at half the load"),
        measurements.LOWER_FREQUENCY.shows("the lean stays"),
        measurements.EARLY_LOOPS.shows("the stick branch stays"),
        measurements.SCAR_MAPS.shows("lengths shorter than modelled"),
    )

    stiffness_N_per_mm: float = parameter(
        "stiffness of the further spring",
        Quantity("N_per_mm", 1.0, 1e9, words=(RIGID,)),
        neutral=float("inf"),
        easy=150.0,
        hard=1500.0,
        interest=(30.0, 1e4),
        logarithmic=True,
    )

    def changed(self, described: Holder, _age: Age) -> Holder:
        compliance = described.tangential_compliance_mm_per_N + 1.0 / self.stiffness_N_per_mm
        return replace(described, tangential_compliance_mm_per_N=compliance)


@dataclass(frozen=True)
class RotationalCompliance(Effect[Holder]):
    """The holder rotates about a pivot above the contact.

    A moment Q·H turns the arm by Q·H/K_θ, which moves the contact by Q·H²/K_θ: for wires this equals a tangential
    spring of stiffness K_θ/H². Flats also tilt, which makes the pressure uneven. Source: rigid-body statics;
    Infante-García et al., Sensors 20 (2020) 4152, on the rig's stiffness.
    """

    name = "rotational_compliance"
    seam = Seam.HOLDER
    ages = Ageing.NEVER
    signature = "as tangential_compliance of K_θ/H²; pressure skew on flats"
    remedy = "stiffen the arm above the contact, or measure displacement at the contact's height"
    confused_with = ("tangential_compliance", "displacement_load_coupling")
    answers = (
        measurements.SECOND_HEIGHT.shows("the points move differently"),
        measurements.ENCODER.shows("less of the stroke reaches the contact"),
        measurements.HALF_LOAD.shows("a lean of the same slope at half the load"),
        measurements.LOWER_FREQUENCY.shows("the lean stays"),
        measurements.EARLY_LOOPS.shows("the stick branch stays"),
        measurements.SCAR_MAPS.shows("lengths shorter than modelled"),
    )
    prior_weight = 0.5

    stiffness_N_mm_per_rad: float = parameter(
        "stiffness against rotation",
        Quantity("N_mm_per_rad", 1.0, 1e12, words=(RIGID,)),
        neutral=float("inf"),
        easy=1.35e5,
        hard=1.35e6,
        interest=(3e4, 1e7),
        logarithmic=True,
    )
    arm_mm: float = parameter(
        "height of the pivot above the contact",
        Quantity("mm", 0.1, 1e3),
        neutral=None,
        easy=30.0,
        hard=30.0,
        # From a flexure next to the contact to a long arm.
        interest=(2.0, 500.0),
        logarithmic=True,
        # K_θ/H² is all that acts on wires.
        held_by=("stiffness_N_mm_per_rad", 2.0),
    )

    def changed(self, described: Holder, _age: Age) -> Holder:
        """The holder with this pivot added; two pivots become the one that moves and tilts as both do together."""
        own, arm = 1.0 / self.stiffness_N_mm_per_rad, self.arm_mm
        before, height = described.rotational_compliance_rad_per_N_mm, described.pivot_height_mm
        if own == 0.0:
            return described
        if before == 0.0:
            return replace(described, rotational_compliance_rad_per_N_mm=own, pivot_height_mm=arm)
        motion, tilt = own * arm**2 + before * height**2, own * arm + before * height
        return replace(described, rotational_compliance_rad_per_N_mm=tilt**2 / motion, pivot_height_mm=motion / tilt)


@dataclass(frozen=True)
class FreePlay(Effect[Holder]):
    """Play in series with the rig's springs: the holder floats without force between two stops.

    Worn joints, a loose clamp or a guide's clearance let the holder cross a gap g at each change of the force's sign:
    twice a cycle the loop runs level at Q = 0 over that width (a shelf), and the energy falls by 2 g Q*. Source: dead
    band in series with a spring, e.g. Tustin, J. IEE 94 IIA (1947) 143, on backlash.
    """

    name = "free_play"
    seam = Seam.HOLDER
    ages = Ageing.NEVER
    signature = "a shelf of the gap's width at Q = 0 after each reversal; energy falls by twice gap times force"
    remedy = "tighten clamps, joints and guides until the shelf at zero force is gone"
    confused_with = ("tangential_compliance",)
    answers = (
        measurements.SECOND_HEIGHT.shows("both points move alike"),
        measurements.ENCODER.shows("less of the stroke reaches the contact"),
        measurements.HALF_LOAD.shows("a shelf of the same width at half the load"),
        measurements.LOWER_FREQUENCY.shows("the shelf stays"),
        measurements.EARLY_LOOPS.shows("the stick branch stays"),
    )

    gap_um: float = parameter(
        "width of the play",
        Quantity("um", 0.0, 1e5),
        neutral=0.0,
        easy=4.0,
        hard=0.8,
        interest=(0.2, 12.0),
        logarithmic=True,
    )

    def changed(self, described: Holder, _age: Age) -> Holder:
        return replace(described, play_mm=described.play_mm + 1e-3 * self.gap_um)


@dataclass(frozen=True)
class HolderInertia(Effect[Holder]):
    """A holder whose mass swings on its springs.

    The force cell in the rig reads u/C, of a holder that moves by m ü + c u̇ + u/C = Q. After each change of the sign of
    friction the reading rings about the plateau with the holder's own frequency, and it is larger than the force by
    (ω/ω₀)² where that changes as a sine. A simulation moves the holder as if it stood still at each instant; its mass
    acts on what the force cell reads. Source: Den Hartog, Trans. ASME 53 (1931) APM-107.
    """

    name = "holder_inertia"
    seam = Seam.HOLDER
    ages = Ageing.NEVER
    signature = "the force overshoots the plateau after each reversal and rings about it; not so at a low frequency"
    remedy = "test at a lower frequency, or stiffen and lighten what lies between contact and force cell"
    confused_with = ("sensor_lag",)
    answers = (
        measurements.LOWER_FREQUENCY.shows("the ringing is gone"),
        measurements.SECOND_HEIGHT.shows("the holder rings, too"),
        measurements.ENCODER.shows("a stroke without ringing"),
    )

    mass_kg: float = parameter(
        "mass that moves with the holder between contact and force cell",
        Quantity("kg", 0.0, 1e3),
        neutral=0.0,
        easy=0.3,
        hard=0.03,
        interest=(0.01, 3.0),
        logarithmic=True,
    )

    def changed(self, described: Holder, _age: Age) -> Holder:
        return replace(described, mass_kg=described.mass_kg + self.mass_kg)

    def may_show(self, chain: Chain) -> bool:
        """False for a mass that swings so much faster than the drive that even ten times as much does nothing."""
        swings = 1e-5 * chain.mass_kg * (2.0 * pi * chain.frequency_Hz) ** 2 * chain.compliance_um_per_N
        return bool(swings.max() > 0.01)


@dataclass(frozen=True)
class Misalignment(Effect[Loading]):
    """A motion that is not parallel to the plane of contact.

    The line of motion rises by β out of the contact plane, so the holder climbs on one stroke and descends on the
    other: Q = P tan(φ + β) out and P tan(φ − β) back, with tan φ = µ. The mean force is P tan β (1 + µ²), and a loading
    spring's force ripples in phase with the motion. Source: statics of the inclined plane; Schmitz, Action, Ziegert &
    Sawyer, J. Tribol. 127 (2005) 673, on axes of force that are not aligned with the motion.
    """

    name = "misalignment"
    seam = Seam.LOADING
    ages = Ageing.NEVER
    needs_load = True
    signature = "a mean force P·tan β (1 + µ²); with a loading spring, load ripple in phase with the motion"
    remedy = "set the load at a right angle to the motion, and zero the force without contact"
    confused_with = ("force_crosstalk",)
    answers = (
        measurements.NORMAL_FORCE.shows("it ripples with the motion"),
        measurements.HALF_LOAD.shows("half the offset at half the load, none without contact"),
    )

    angle_deg: float = parameter(
        "rise of the line of motion out of the contact plane",
        Quantity("deg", -20.0, 20.0),
        neutral=0.0,
        easy=2.0,
        hard=0.4,
        interest=(-3.0, 3.0),
    )

    def changed(self, described: Loading, _age: Age) -> Loading:
        return replace(described, misalignment_rad=described.misalignment_rad + radians(self.angle_deg))


@dataclass(frozen=True)
class NormalLoadDrift(Effect[Loading]):
    """A load that rises or falls in proportion to the cycles.

    Creep of a loading spring or slow friction in its guide, beyond the relaxation that the worn depth and the spring's
    stiffness give anyway: P(n) = P (1 + f n/100 000), never below a hundredth of P. Source: Infante-García et al.,
    Sensors 20 (2020) 4152, on the spring-loaded rig.
    """

    name = "normal_load_drift"
    seam = Seam.LOADING
    ages = Ageing.BY_CYCLES
    needs_load = True
    signature = "the loop's height drifts; the scar becomes shallower or deeper with it"
    remedy = "log the normal force; check weights, spring and hinge of the load"
    confused_with = ("friction_evolution", "friction_offset")
    answers = (
        measurements.NORMAL_FORCE.shows("it drifts"),
        measurements.OTHER_STROKE.shows("the same course over the cycles"),
    )

    fraction_per_100k_cycles: float = parameter(
        "relative change of the load in 100 000 cycles",
        Quantity("per_100k_cycles", -1e4, 1e4),
        neutral=0.0,
        easy=-0.15,
        hard=-0.04,
        interest=(-0.3, 0.3),
    )

    def changed(self, described: Loading, age: Age) -> Loading:
        factor = max(1.0 + self.fraction_per_100k_cycles * age.cycles / 1e5, 0.01)
        return replace(described, normal_load_N=factor * described.normal_load_N)


@dataclass(frozen=True)
class CrossingAngleError(Effect[Specimens]):
    """Wires mounted at another angle than the stated one.

    The fixed wire's axis is turned about the contact normal. Near 90° the contact ellipse and the friction force change
    only to second order; the scar's outline turns and skews to first order. Source: geometry; Johnson, Contact
    Mechanics (1985), ch. 4.1, for the ellipse of cylinders crossed at any angle.
    """

    name = "crossing_angle_error"
    seam = Seam.SPECIMENS
    contacts = (kinds.CROSSED_WIRES,)
    ages = Ageing.NEVER
    signature = "nothing in loops to first order; a skewed scar"
    remedy = "measure the angle between the specimens and align the clamps"
    confused_with = ()
    answers = (measurements.INTERRUPTED_SCARS.shows("skewed outlines"), measurements.SCAR_MAPS.shows("skewed outlines"))

    angle_deg: float = parameter(
        "true crossing angle less the stated one",
        Quantity("deg", -60.0, 60.0),
        neutral=0.0,
        easy=5.0,
        hard=1.5,
        interest=(-6.0, 6.0),
    )

    def changed(self, described: Specimens, _age: Age) -> Specimens:
        return replace(described, crossing_angle_deg=described.crossing_angle_deg + self.angle_deg)


@dataclass(frozen=True)
class Plasticity(Effect[Specimens]):
    """Bodies that yield at another stress than the stated one.

    Where they would have to bear more than their metal does, bodies keep a print of the first strokes. A simulation
    limits the pressure, as of bodies that state a yield stress; the fast model that of a foundation. `flattening_um` is
    the former parameter, which a diagnosis still tries: an approach at whose overlap both recede by half, as wear.
    Source: Johnson, Contact Mechanics (1985), ch. 6.
    """

    name = "plasticity"
    seam = Seam.SPECIMENS
    contacts = kinds.AT_A_POINT
    ages = Ageing.NEVER
    needs_load = True
    signature = "a larger contact before any wear; a depth that wear coefficient times energy does not explain"
    remedy = "press specimens together without motion and map the imprint: a print needs no energy, and has a rim"
    confused_with = ("wear_rate_offset", "wear_rate_evolution")
    answers = (measurements.INTERRUPTED_SCARS.shows("scars before any wear, with a rim"),)
    model_error = 0.2
    #: Metal that flows has walls only at the ends of its prints, and worn edges are printed in single cycles.
    law_error = 0.5

    yield_stress_MPa: float = parameter(
        "yield stress of the body that yields first",
        Quantity("MPa", 1.0, 1e5, words=("stated",)),
        neutral=inf,
        easy=250.0,
        hard=900.0,
        interest=(120.0, 1700.0),
        logarithmic=True,
        default=inf,
    )
    flattening_um: float = parameter(
        "approach of the bodies that is imposed as wear",
        Quantity("um", 0.0, 20.0),
        neutral=0.0,
        easy=2.0,
        hard=0.5,
        interest=(0.1, 4.0),
        logarithmic=True,
        default=0.0,
        instead=True,
    )

    def changed(self, described: Specimens, _age: Age) -> Specimens:
        stress = described.yield_stress_MPa if self.yield_stress_MPa == inf else self.yield_stress_MPa
        flattening = described.flattening_mm + 1e-3 * self.flattening_um
        return replace(described, yield_stress_MPa=stress, flattening_mm=flattening)

    def predicted(self, chain: Chain) -> Chain:
        kept = chain.print_um
        if self.yield_stress_MPa != inf:
            contact = 1e-3 * sqrt(chain.fresh_area_um2 / pi), 1e-3 * chain.radius_um
            kept = 1e3 * kept_approach(float(chain.load_N[0]), *contact, self.yield_stress_MPa) + 0.0 * kept
        return replace(chain, flattening_um=chain.flattening_um + self.flattening_um, print_um=kept)


@dataclass(frozen=True)
class HeldDisplacement(Effect[Control]):
    """A drive that holds its displacement where it is stated to hold the slip or the energy.

    A contact that wears carries more tangential force Q along walls inclined by θ, Q = P tan(θ ± φ) with the load P
    and tan φ = µ, and a rig of stiffness K takes Q/K of the stroke. A drive that holds the slip increases its
    displacement by that; one that holds its displacement loses it from the slip. Where blocks of cycles follow one
    another, this displacement is held in all. Source: Infante-García et al., Sensors
    20 (2020) 4152, finding 2.
    """

    name = "held_displacement"
    seam = Seam.DRIVE
    ages = Ageing.NEVER
    of_held_drives = True
    signature = "the displacement amplitude stays as it is from the first cycle on, and slip and energy fall"
    remedy = "log slip and displacement amplitude over the cycles: what is held stays, and the other changes"
    confused_with = ()
    answers = (
        measurements.ENCODER.shows("the stroke stays the same over the cycles"),
        measurements.EARLY_LOOPS.shows("the same stroke in all of them"),
    )

    displacement_amplitude_um: float = parameter(
        "displacement amplitude that the drive holds",
        Quantity("um", 0.01, 1e4),
        neutral=1.0,
        easy=0.9,
        hard=0.98,
        interest=(0.8, 1.25),
        logarithmic=True,
        share_of="conditions.displacement_amplitude_um",
    )

    def changed(self, _described: Control, _age: Age) -> Control:
        return Control(self.displacement_amplitude_um)
