"""Tangential compliance: the rig yields further along the motion."""

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
