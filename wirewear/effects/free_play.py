"""Free play: the holder floats between two stops."""

from dataclasses import dataclass, replace

from solvers import Holder
from wirewear.base.quantity import Quantity
from wirewear.effects.effect import Effect
from wirewear.effects.measurements import EARLY_LOOPS, ENCODER, HALF_LOAD, LOWER_FREQUENCY, SECOND_HEIGHT
from wirewear.effects.parameter import parameter
from wirewear.effects.seams import Age, Ageing, Seam


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
