"""Oxygen in the contact: it diffuses in from the edges and friction uses it up; where none is left, wear is another.

Consumption per area in proportion to the friction power density q, whatever oxygen is left (zero order), and diffusion
in the gap give D h c'' = κ q in a wide contact, with c = 1 at its edge: c = (1 − s/d)² at the distance s from the edge,
and none beyond d = √(2 D h/(κ q)). So q d² is a constant of the pair of materials, its supply. Contact oxygenation:
Baydoun, Arnaud and Fouvry, Wear 458-459 (2020) 203397, and Arnaud, Baydoun and Fouvry, Tribol. Int. 161 (2021) 107077.
"""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array, BoolArray
from solvers.errors import SolverError

# Over the last part of the way that oxygen gets, the wear coefficient passes linearly from one value to the other.
_FADING = 0.3


@dataclass(frozen=True)
class OxygenSupply:
    """How far oxygen gets, and what its lack does.

    supply_W: friction power density (W/mm²) times the square of the distance (mm²) that oxygen gets from the edge.
    starved_factor: wear coefficient without oxygen over that with it.  frequency_Hz: cycles per second.

    Raises:
        SolverError: a number that cannot be.
    """

    supply_W: float
    starved_factor: float
    frequency_Hz: float = 1.0

    def __post_init__(self) -> None:
        if not (self.supply_W > 0.0 and self.starved_factor >= 0.0 and self.frequency_Hz > 0.0):
            raise SolverError("oxygen needs a positive supply and frequency, and a factor that is not negative")

    def reach_mm(self, power_density_W_per_mm2: float) -> float:
        """Distance from the contact's edge that oxygen gets at a friction power density."""
        return float(np.sqrt(self.supply_W / max(power_density_W_per_mm2, 1e-300)))

    def factors(self, distance_mm: Array, reach_mm: float) -> Array:
        """Factors on the wear coefficient at distances from the contact's edge."""
        breathes = np.clip((1.0 - distance_mm / reach_mm) / _FADING, 0.0, 1.0)
        return np.asarray(self.starved_factor + (1.0 - self.starved_factor) * breathes)


def edge_distances(plane_mm: Array, pressed: BoolArray) -> Array:
    """Distance (n,) in mm of every node (n, 2) to the nearest that bears no load; 0 where it bears none itself."""
    from scipy.spatial import KDTree

    distance = np.zeros(len(plane_mm))
    if pressed.all():
        return np.full(len(plane_mm), np.inf)
    if pressed.any():
        distance[pressed] = KDTree(plane_mm[~pressed]).query(plane_mm[pressed])[0]
    return distance
