"""What sizes of effects are drawn from: how severe a case is, its nominal test, and random numbers."""

from dataclasses import dataclass
from math import acos

import numpy as np

from studies.blind.generators.nominal import Nominal

#: Severity of hard and of easy cases; 0 is the smallest size and 1 the largest, geometrically between.
SEVERITY = {"hard": (0.0, 0.45), "easy": (0.55, 1.0)}
MOST_TAKEN = 0.15  #: Largest share of the stroke that a compliance or play takes.


@dataclass(frozen=True)
class Draw:
    """What sizes are drawn from: a severity from 0 to 1, the nominal test, and random numbers."""

    severity: float
    nominal: Nominal
    random: np.random.Generator

    def between(self, low: float, high: float) -> float:
        """The size of that severity."""
        return float(low * (high / low) ** self.severity)

    def sign(self, positive: float = 0.5) -> float:
        """1 or −1, the former with a probability."""
        return 1.0 if self.random.random() < positive else -1.0

    def spread(self, low: float, high: float) -> float:
        """A value between two, evenly in its logarithm, whatever the severity."""
        return float(np.exp(self.random.uniform(np.log(low), np.log(high))))

    @property
    def cycles(self) -> float:
        """Cycles within which something settles: between a few hundredths and a third of the test."""
        return self.nominal.cycles * self.spread(0.02, 0.33)

    @property
    def plateau_N(self) -> float:
        """Tangential force of the sliding contact."""
        return self.nominal.friction * self.nominal.load_N

    @property
    def scar_depth_um(self) -> float:
        """Depth of both expected scars together, h²/2R of crossed wires."""
        return 1e3 * self.nominal.expected_scar_mm**2 / self.nominal.diameter_mm

    def turning_phase(self, low: float, high: float) -> float:
        """Phase after a reversal within which half of the way passes that the rig's spring takes, and so many µm more.

        A cosine moves by d within the phase arccos(1 − d/A) after its reversal. Only half of the spring's way counts:
        the force turns faster than on average towards the end of it.
        """
        stiffness = self.nominal.stiffness_N_per_mm
        spring_um = 0.0 if stiffness is None else 2e3 * self.plateau_N / stiffness
        return acos(1.0 - (0.5 * spring_um + self.length_um(low, high)) / self.nominal.amplitude_um)

    def length_um(self, low: float, high: float) -> float:
        """A length of that severity, limited by the stroke."""
        return min(self.between(low, high), MOST_TAKEN * self.nominal.amplitude_um)
