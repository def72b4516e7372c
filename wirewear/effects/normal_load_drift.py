"""Normal load drift: the load rises or falls over the test."""

from dataclasses import dataclass, replace

from wirewear.base.quantity import Quantity
from wirewear.effects.effect import Effect
from wirewear.effects.measurements import NORMAL_FORCE, OTHER_STROKE
from wirewear.effects.parameter import parameter
from wirewear.effects.seams import Age, Ageing, Loading, Seam


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
