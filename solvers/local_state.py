"""What a law may know of the nodes where it acts: how fast they slide, and what both surfaces have been through."""

from collections.abc import Callable
from dataclasses import dataclass, field

from geometry.arrays import Array
from solvers.contact_state import WearState
from solvers.drive import Drive


@dataclass(frozen=True)
class DriveTiming:
    """How fast the drive moves along its stroke; one of amplitude 0 is so slow that its speed counts for nothing."""

    drive: Drive = field(default_factory=lambda: Drive(0.0))
    frequency_Hz: float = 1.0

    def speed_mm_per_s(self, drive_mm: float, *, falling: bool) -> float:
        """Its speed where it is displaced by so much, on its way back or out."""
        amplitude = self.drive.amplitude_mm
        if amplitude == 0.0:
            return 0.0
        return amplitude * self.frequency_Hz * self.drive.waveform.speed(drive_mm / amplitude, falling=falling)


@dataclass(frozen=True)
class LocalState:
    """k nodes of the primary as they face the secondary; nothing is worked out before a law asks for it.

    wear: of both bodies.  of_primary, of_secondary: take a field (n,) of either patch to the nodes, (k,).
    sliding: their speeds (k,), mm/s.  primary_is_upper: which body is which.
    """

    wear: WearState
    of_primary: Callable[[Array], Array]
    of_secondary: Callable[[Array], Array]
    sliding: Callable[[], Array]
    primary_is_upper: bool

    @property
    def speed_mm_per_s(self) -> Array:
        """Sliding speed (k,); 0 where a node sticks."""
        return self.sliding()

    @property
    def energy_mJ_per_mm2(self) -> Array:
        """Friction energy (k,) per plane area that the surfaces have taken so far, as a mean of both."""
        primary, secondary = (energy.ravel() for energy in (self.wear.primary_energy, self.wear.secondary_energy))
        return 0.5 * (self.of_primary(primary) + self.of_secondary(secondary))
