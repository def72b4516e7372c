"""An effect of another package: a clamp that works loose."""

from dataclasses import dataclass, replace

from solvers import Holder
from wirewear.base.course import Course
from wirewear.effects import Age, Ageing, Effect, Quantity, Seam, parameter
from wirewear.effects.measurements import EARLY_LOOPS, ENCODER


@dataclass(frozen=True)
class LooseningClamp(Effect[Holder]):
    """A clamp that works loose: a spring in series with the rig, rigid at first.

    Its compliance tends to 1/K: (1 - exp(-n/n_c))/K after n cycles. Source: an exponential course, for want of a law.
    """

    name = "loosening_clamp"
    seam = Seam.HOLDER
    signature = "stick branches lean ever more; slip and energy fall with it"
    remedy = "tighten the clamp, and mark it so that its slip shows"
    ages = Ageing.BY_CYCLES
    confused_with = ("tangential_compliance", "third_body")
    answers = (
        ENCODER.shows("less of the stroke reaches the contact"),
        EARLY_LOOPS.shows("the stick branch is as modelled at first and softens later"),
    )
    prior_weight = 0.5

    final_stiffness_N_per_mm: float = parameter(
        "stiffness of the clamp in the end",
        Quantity("N_per_mm", 1.0, 1e9, words=("rigid",)),
        neutral=float("inf"),
        easy=200.0,
        hard=1500.0,
        interest=(30.0, 1e4),
        logarithmic=True,
    )
    cycles: float = parameter(
        "cycles after which 63 % of the compliance has come",
        Quantity("cycles", 1.0, 1e9),
        neutral=None,
        easy=3000.0,
        hard=3000.0,
        interest=(30.0, 1e5),
        logarithmic=True,
    )

    def changed(self, described: Holder, age: Age) -> Holder:
        added = Course(0.0, 1.0 / self.final_stiffness_N_per_mm, self.cycles).at(age.cycles)
        return replace(described, tangential_compliance_mm_per_N=described.tangential_compliance_mm_per_N + added)
