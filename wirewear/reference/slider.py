"""A Coulomb slider behind a spring with free play, under a load that changes: what a loop of a yielding rig comes to.

The spring follows the drive until it carries what friction bears at the time; then the slider goes along. Where nothing
presses, it stays with the drive, up to the play. Nothing here is shared with the solver.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array

_CYCLES = 3  #: Until the loop is closed.


@dataclass(frozen=True)
class SliderLoop:
    """A closed loop, from the drive's rest at +amplitude on; arrays (n,)."""

    displacement_mm: Array
    place_mm: Array  #: Of the slider.
    force_N: Array

    @property
    def slip_amplitude_mm(self) -> float:
        """Half of the slider's way."""
        return 0.5 * float(np.ptp(self.place_mm))

    @property
    def energy_mJ(self) -> float:
        """Friction work of the cycle, by the trapezoidal rule."""
        means = 0.5 * (self.force_N[1:] + self.force_N[:-1])
        return float(means @ np.diff(self.place_mm))


def slider_loop(
    amplitude_mm: float,
    friction_limit_N: Callable[[Array], Array],
    compliance_mm_per_N: Callable[[Array], Array],
    play_mm: float = 0.0,
    samples: int = 4000,
) -> SliderLoop:
    """The loop of a sinusoidal drive.

    friction_limit_N, compliance_mm_per_N: what friction bears, and the spring's, at shares (n,) of the cycle since the
    drive's rest at +amplitude.
    """
    time = np.arange(samples + 1) / samples
    drive, limit, half_play = amplitude_mm * np.cos(2.0 * np.pi * time), friction_limit_N(time), 0.5 * play_mm
    compliance, place, places = compliance_mm_per_N(time), amplitude_mm, np.empty_like(time)
    reach = limit * compliance + half_play
    for _ in range(_CYCLES):
        for k, moved in enumerate(drive):
            place = min(max(place, moved - reach[k]), moved + reach[k])
            places[k] = place
    stretch, slides = drive - places, limit * np.sign(np.gradient(places))
    sprung = np.sign(stretch) * np.maximum(np.abs(stretch) - half_play, 0.0)
    return SliderLoop(drive, places, np.divide(sprung, compliance, out=slides, where=compliance > 0.0))
