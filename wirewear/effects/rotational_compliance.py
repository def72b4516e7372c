"""Rotational compliance: the holder tilts about its pivot."""

from dataclasses import dataclass, replace

from solvers import Holder
from wirewear.base.quantity import Quantity
from wirewear.effects.effect import Effect
from wirewear.effects.measurements import EARLY_LOOPS, ENCODER, HALF_LOAD, LOWER_FREQUENCY, SCAR_MAPS, SECOND_HEIGHT
from wirewear.effects.parameter import RIGID, parameter
from wirewear.effects.seams import Age, Ageing, Seam


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
