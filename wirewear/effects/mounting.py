"""Effects of how wires are mounted and loaded: another angle, flattened wires, a leaning motion, a load that drifts."""

from dataclasses import dataclass, replace
from math import radians

from wirewear.base.quantity import Quantity
from wirewear.effects.effect import Effect
from wirewear.effects.measurements import HALF_LOAD, INTERRUPTED_SCARS, NORMAL_FORCE, OTHER_STROKE, SCAR_MAPS
from wirewear.effects.parameter import AT_A_POINT, parameter
from wirewear.effects.seams import Age, Ageing, Loading, Seam, Specimens


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
        NORMAL_FORCE.shows("it ripples with the motion"),
        HALF_LOAD.shows("half the offset at half the load, none without contact"),
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
        """The loading with the motion leaning so much more."""
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
    answers = (NORMAL_FORCE.shows("it drifts"), OTHER_STROKE.shows("the same course over the cycles"))

    fraction_per_100k_cycles: float = parameter(
        "relative change of the load in 100 000 cycles",
        Quantity("per_100k_cycles", -1e4, 1e4),
        neutral=0.0,
        easy=-0.15,
        hard=-0.04,
        interest=(-0.3, 0.3),
    )

    def changed(self, described: Loading, age: Age) -> Loading:
        """The load of that cycle."""
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
    contacts = ("crossed-wires",)
    ages = Ageing.NEVER
    signature = "nothing in loops to first order; a skewed scar"
    remedy = "measure the angle between the specimens and align the clamps"
    confused_with = ()
    answers = (INTERRUPTED_SCARS.shows("skewed outlines"), SCAR_MAPS.shows("skewed outlines"))

    angle_deg: float = parameter(
        "true crossing angle less the stated one",
        Quantity("deg", -15.0, 15.0),
        neutral=0.0,
        easy=5.0,
        hard=1.5,
        interest=(-6.0, 6.0),
    )

    def changed(self, described: Specimens, _age: Age) -> Specimens:
        """Wires at the true angle."""
        return replace(described, crossing_angle_deg=described.crossing_angle_deg + self.angle_deg)


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
    contacts = AT_A_POINT
    ages = Ageing.NEVER
    needs_load = True
    signature = "a larger contact before any wear; a depth that wear coefficient times energy does not explain"
    remedy = "press specimens together without motion and map the imprint"
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
