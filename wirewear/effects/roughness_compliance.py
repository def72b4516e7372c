"""Roughness compliance: asperities give way until they are worn in."""

from dataclasses import dataclass, replace

from solvers import RoughLayer
from wirewear.base.course import Course
from wirewear.base.quantity import Quantity
from wirewear.effects.chain import Chain
from wirewear.effects.effect import Effect
from wirewear.effects.measurements import EARLY_LOOPS, ENCODER, HALF_LOAD, LOWER_FREQUENCY, SECOND_HEIGHT
from wirewear.effects.parameter import exponent, form, order, parameter, part, share
from wirewear.effects.seams import Age, Ageing, ContactLaw, Seam

# Mindlin: tangential over normal compliance of a rough interface, (2 − ν)/(2(1 − ν)) at ν = 0.3.
_TANGENTIAL_TO_NORMAL = 1.21

# Of a rough layer that has worn in, less than this share is as good as none.
_WORN_AWAY = 1e-6

# A layer that keeps more of its height over a record is a spring by another name. Springs left out of the library were
# fitted as layers that keep 0.8 to 0.9 (T1_twentieth), laws of other form keep a half.
_MOST_KEPT = 0.7


@dataclass(frozen=True)
class RoughnessCompliance(Effect[ContactLaw]):
    """Asperities that give way before they are worn in.

    Asperities of exponentially distributed heights close by s ln(1 + p/p_c) under the pressure p, with p_c = 100 MPa,
    and shear 1.21 times as easily (Mindlin): a soft stick branch that stiffens with the load. Their height falls as
    they wear in, s(n) = s exp(−n/n_c). Source: Greenwood & Williamson, Proc. R. Soc. A 295 (1966) 300.
    """

    name = "roughness_compliance"
    seam = Seam.CONTACT
    ages = Ageing.BY_CYCLES
    signature = "a soft stick branch early on that vanishes as it wears in and stiffens with the load"
    confused_with = ("tangential_compliance", "third_body")
    answers = (
        SECOND_HEIGHT.shows("both points move alike"),
        ENCODER.shows("less of the stroke reaches the contact"),
        HALF_LOAD.shows("a stick branch that is softer at half the load"),
        LOWER_FREQUENCY.shows("the soft branch stays"),
        EARLY_LOOPS.shows("the stick branch stiffens"),
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
    cycles: float = parameter(
        "cycles over which the asperities wear to 37 % of their height",
        Quantity("cycles", 1.0, 1e9),
        neutral=None,
        easy=3000.0,
        hard=3000.0,
        interest=(30.0, 1e5),
        logarithmic=True,
    )

    steepness: float = form(exponent(0.55))
    order: float = form(order(0.7))
    lasting: float = form(share(0.005, 0.6))
    spreading: float = form(part("of its height that spreads the pressure", -0.5, 1.5), contacts=("crossed-wires",))

    def changed(self, described: ContactLaw, age: Age) -> ContactLaw:
        """The law with the rough layer as it is at that cycle."""
        height_um = self._height_um.at(age.cycles)
        if height_um <= _WORN_AWAY * self.layer_um:
            return described
        return replace(described, layers=(*described.layers, RoughLayer(1e-3 * height_um)))

    def foreseen(self, chain: Chain) -> Chain:
        """A spring: asperities that close by s ln p under a pressure p give way by s/P per newton of the load P."""
        height_um = self._height_um.at(chain.cycles)
        added = _TANGENTIAL_TO_NORMAL * height_um / chain.load_N
        return replace(
            chain,
            compliance_um_per_N=chain.compliance_um_per_N + added,
            rough_um=chain.rough_um + self.spreading * height_um,
        )

    def recognised_between(self, first_cycle: float, last_cycle: float) -> bool:
        """Whether the layer wears in between them."""
        return self._height_um.at(last_cycle) <= _MOST_KEPT * self._height_um.at(first_cycle)

    @property
    def _height_um(self) -> Course:
        return Course(self.layer_um, 0.0, self.cycles, self.steepness, self.order, self.lasting)
