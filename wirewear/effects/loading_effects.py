"""Effects in the loading: a motion that leans against the load, and a load that drifts."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import radians

from wirewear.effects.effect import Effect
from wirewear.effects.parameter import parameter
from wirewear.effects.seams import Age, Loading, Seam
from wirewear.quantity import Quantity


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
    needs_load = True
    signature = "a mean force P·tan β (1 + µ²); with a loading spring, load ripple in phase with the motion"
    confused_with = ("force_crosstalk",)
    split_by = "an unloaded stroke, in which crosstalk remains; a test at another friction"

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
    needs_load = True
    signature = "the loop's height drifts; the scar becomes shallower or deeper with it"
    confused_with = ("friction_evolution", "friction_offset")
    split_by = "the measured normal force"

    fraction_per_100k_cycles: float = parameter(
        "relative change of the load in 100 000 cycles",
        Quantity("1", -0.99, 5.0),
        neutral=0.0,
        easy=-0.15,
        hard=-0.04,
        interest=(-0.3, 0.3),
    )

    def changed(self, described: Loading, age: Age) -> Loading:
        """The load of that cycle."""
        factor = max(1.0 + self.fraction_per_100k_cycles * age.cycles / 1e5, 0.01)
        return replace(described, normal_load_N=factor * described.normal_load_N)
