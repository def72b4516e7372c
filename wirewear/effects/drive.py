"""Effects of what moves the bodies: a drive that holds another figure than is stated."""

from dataclasses import dataclass

from wirewear.base.errors import Quantity
from wirewear.effects import measurements
from wirewear.effects.effect import Effect
from wirewear.effects.parameter import parameter
from wirewear.effects.seams import Age, Ageing, Control, Seam


@dataclass(frozen=True)
class HeldDisplacement(Effect[Control]):
    """A drive that holds its displacement where it is stated to hold the slip or the energy.

    A contact that wears carries more force along its walls, Q = P tan(θ ± φ), and the rig takes Q/K of the stroke. A
    drive that holds the slip grows by that; one that holds its displacement loses it from the slip. Where blocks follow
    one another all have this displacement. Source: Infante-García et al., Sensors 20 (2020) 4152, finding 2.
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
        """That displacement, whatever the loop shows."""
        return Control(self.displacement_amplitude_um)
