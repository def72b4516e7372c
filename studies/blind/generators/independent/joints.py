"""Joints of the holder whose give is not a spring's: how far they let it move under a force, branch by branch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Joint(Protocol):
    """Anything in series with the contact that moves with the tangential force."""

    def moved_mm(self, force_N: Array, held_from_N: float, direction: int) -> Array:
        """Displacement along a branch (n,), whose force went from `held_from_N` in a direction since the reversal."""
        ...


@dataclass(frozen=True)
class OpeningJoint:
    """A bolted joint whose faces part once the force exceeds the preload of its screws: c sign(Q) max(|Q| − Q_0, 0).

    Below the preload the faces bear the force, above it the screws alone do (VDI 2230, joint diagram). It is elastic.
    """

    preload_N: float
    mm_per_N: float

    def moved_mm(self, force_N: Array, _held_from_N: float, _direction: int) -> Array:
        """What the screws stretch by."""
        return np.asarray(self.mm_per_N * (force_N - np.clip(force_N, -self.preload_N, self.preload_N)))


@dataclass(frozen=True)
class MicroslippingJoint:
    """A joint whose faces slip from their rim inwards, more the further the force has swung: h ΔQ²/2 on either branch.

    A joint's microslip has such lens-shaped loops (Gaul & Nitsche, Applied Mechanics Reviews 54 (2001) 93); the
    quadratic law is Rayleigh's. Its loop closes from −h ΔQ_max²/4 to +h ΔQ_max²/4.
    """

    mm_per_N2: float

    def moved_mm(self, force_N: Array, held_from_N: float, direction: int) -> Array:
        """What has slipped since the reversal, around the middle of both reversals."""
        swung = np.maximum(direction * (force_N - held_from_N), 0.0)
        whole = float(direction * (force_N[-1] - held_from_N))
        return np.asarray(direction * 0.5 * self.mm_per_N2 * (swung**2 - 0.5 * whole**2))
