"""Debris between the surfaces that moves to the contact's edge and leaves it, and protects what it covers.

A balance for each node: the thickness h of the debris grows by the share of the worn depth that becomes debris, and
debris moves by a part of the slip towards the nearest edge of what the contact touches in a cycle, at a distance d.
Over a path s of slip it passes that distance `moving` s / d times. Source and ejection are the flows of Fillot,
Iordanoff and Berthier, Wear 262 (2007) 949, with an ejection in proportion to the thickness.
"""

from dataclasses import dataclass
from math import inf

import numpy as np

from geometry.arrays import Array
from solvers.errors import SolverError


@dataclass(frozen=True)
class DebrisFlow:
    """How debris leaves the contact and how it protects. Raises SolverError if `moving` is negative or `protecting_mm`
    is not positive.
    """

    #: Part of the slip by which debris moves towards the nearest edge; 0: none leaves, infinite: all leaves at once.
    moving: float
    #: Thickness that takes up half of the slip, which then wears nothing: 1 / (1 + h / protecting_mm) of it wears.
    protecting_mm: float = inf

    def __post_init__(self) -> None:
        if not (self.moving >= 0.0 and self.protecting_mm > 0.0):
            raise SolverError("debris must move by a share that is not negative, and protect by a positive thickness")

    def passages(self, path_mm: Array, edge_distance_mm: Array | float) -> Array:
        """How often (any shape) debris would pass the distance to the contact's edge over a path of slip, both
        mm and the distance positive.
        """
        return np.asarray(self.moving * path_mm / edge_distance_mm)

    def wearing(self, thickness_mm: Array) -> Array:
        """Share of the slip that wears the surfaces under debris of this thickness in mm, of its shape."""
        return np.asarray(1.0 / (1.0 + thickness_mm / self.protecting_mm))


def staying(passages: Array) -> tuple[Array, Array]:
    """Shares, of the shape of `passages`, that stay of debris that was there before and of debris that is made evenly
    meanwhile; exact for a constant source. The second is 1 / passages where much leaves: thickness is source over rate.
    """
    some = np.maximum(passages, 1e-12)
    return np.exp(-passages), np.where(passages > 1e-12, -np.expm1(-some) / some, 1.0)
