"""Effects of what holds the wires: springs along the motion and about a pivot, and play."""

from dataclasses import dataclass, replace

from solvers import Holder
from wirewear.base.quantity import Quantity
from wirewear.effects.effect import Effect
from wirewear.effects.measurements import EARLY_LOOPS, ENCODER, HALF_LOAD, LOWER_FREQUENCY, SCAR_MAPS, SECOND_HEIGHT
from wirewear.effects.parameter import RIGID, parameter
from wirewear.effects.seams import Age, Ageing, Seam


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
        SECOND_HEIGHT.shows("both points move alike"),
        ENCODER.shows("less of the stroke reaches the contact"),
        HALF_LOAD.shows("a lean of the same slope at half the load"),
        LOWER_FREQUENCY.shows("the lean stays"),
        EARLY_LOOPS.shows("the stick branch stays"),
        SCAR_MAPS.shows("lengths shorter than modelled"),
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
        """The holder with the spring in series."""
        compliance = described.tangential_compliance_mm_per_N + 1.0 / self.stiffness_N_per_mm
        return replace(described, tangential_compliance_mm_per_N=compliance)


@dataclass(frozen=True)
class RotationalCompliance(Effect[Holder]):
    """The holder rotates about a pivot above the contact.

    A moment Q·H turns the arm by Q·H/K_θ, which moves the contact by Q·H²/K_θ: for wires the same as a tangential
    spring of K_θ/H². Flats feel the tilt, too: the pressure skews. Source: rigid-body statics; Infante-García et al.,
    Sensors 20 (2020) 4152, on the rig's stiffness.
    """

    name = "rotational_compliance"
    seam = Seam.HOLDER
    ages = Ageing.NEVER
    signature = "as tangential_compliance of K_θ/H²; pressure skew on flats"
    remedy = "stiffen the arm above the contact, or measure displacement at the contact's height"
    confused_with = ("tangential_compliance", "displacement_load_coupling")
    answers = (
        SECOND_HEIGHT.shows("the points move differently"),
        ENCODER.shows("less of the stroke reaches the contact"),
        HALF_LOAD.shows("a lean of the same slope at half the load"),
        LOWER_FREQUENCY.shows("the lean stays"),
        EARLY_LOOPS.shows("the stick branch stays"),
        SCAR_MAPS.shows("lengths shorter than modelled"),
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
        interest=(10.0, 100.0),
        logarithmic=True,
        # K_θ/H² is all that acts on wires.
        held_by=("stiffness_N_mm_per_rad", 2.0),
    )

    def changed(self, described: Holder, _age: Age) -> Holder:
        """The holder with that pivot; with two, the one that moves and tilts as both do together."""
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
    the loop has a shelf of that width at Q = 0, twice a cycle, and the energy falls by 2 g Q*. Source: dead band in
    series with a spring, e.g. Tustin, J. IEE 94 IIA (1947) 143, on backlash.
    """

    name = "free_play"
    seam = Seam.HOLDER
    ages = Ageing.NEVER
    signature = "a shelf of the gap's width at Q = 0 after each reversal; energy falls by twice gap times force"
    remedy = "tighten clamps, joints and guides until the shelf at zero force is gone"
    confused_with = ("tangential_compliance",)
    answers = (
        SECOND_HEIGHT.shows("both points move alike"),
        ENCODER.shows("less of the stroke reaches the contact"),
        HALF_LOAD.shows("a shelf of the same width at half the load"),
        LOWER_FREQUENCY.shows("the shelf stays"),
        EARLY_LOOPS.shows("the stick branch stays"),
    )

    gap_um: float = parameter(
        "width of the play",
        Quantity("um", 0.0, 1e3),
        neutral=0.0,
        easy=4.0,
        hard=0.8,
        interest=(0.2, 12.0),
        logarithmic=True,
    )

    def changed(self, described: Holder, _age: Age) -> Holder:
        """The holder with this play added to its own."""
        return replace(described, play_mm=described.play_mm + 1e-3 * self.gap_um)
