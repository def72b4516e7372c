"""Local energy wear law on both surfaces.

V = alpha E locally (Fouvry et al., Wear 255 (2003) 287): a point that dissipates the friction energy e per area
recedes by alpha e. The primary's nodes take their share directly; the secondary's by the transposed transfer
operator, so worn volume equals alpha times energy to round-off on both bodies.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry import ContactPatch
from solvers.contact_state import WearState
from solvers.errors import SolverError
from solvers.pairing import Pairing

Array = NDArray[np.float64]


@dataclass(frozen=True)
class WearRates:
    """Energy wear coefficients of the two bodies in mm³/mJ."""

    upper_mm3_per_mJ: float = 0.0
    lower_mm3_per_mJ: float = 0.0

    def __post_init__(self) -> None:
        if self.upper_mm3_per_mJ < 0.0 or self.lower_mm3_per_mJ < 0.0:
            raise SolverError("energy wear coefficients must not be negative")

    @property
    def none(self) -> bool:
        """Whether nothing wears."""
        return self.upper_mm3_per_mJ == 0.0 and self.lower_mm3_per_mJ == 0.0

    def split(self, primary_is_upper: bool) -> tuple[float, float]:
        """Coefficients of the primary and the secondary body."""
        pair = (self.upper_mm3_per_mJ, self.lower_mm3_per_mJ)
        return pair if primary_is_upper else (pair[1], pair[0])


def worn_gap_operator(pairing: Pairing, secondary_areas: Array, primary_rate: float, secondary_rate: float) -> Array:
    """Area-weighted gap opened at each paired node by friction energy at each other, shape (k, k), per cycle."""
    mass = pairing.primary[:, pairing.nodes]
    transfer = pairing.secondary
    spread = transfer.multiply(1.0 / secondary_areas[None, :]).tocsr()
    return np.asarray((primary_rate * mass + secondary_rate * (spread @ transfer.T)).todense())


def deposited(
    wear: WearState,
    pairing: Pairing,
    energy: Array,
    cycles: float,
    rates: tuple[float, float],
    secondary_patch: ContactPatch,
) -> WearState:
    """The wear state after friction energy (k,) per area at the paired nodes, repeated `cycles` times."""
    if cycles == 0.0 or not energy.any():
        return wear
    primary = np.zeros(wear.primary_depth.shape)
    primary.flat[pairing.nodes] = cycles * energy
    secondary_nodes = cycles * (pairing.secondary.T @ energy) / secondary_patch.node_areas()
    secondary = np.asarray(secondary_nodes).reshape(wear.secondary_depth.shape)
    return WearState(
        primary_depth=wear.primary_depth + rates[0] * primary,
        secondary_depth=wear.secondary_depth + rates[1] * secondary,
        primary_energy=wear.primary_energy + primary,
        secondary_energy=wear.secondary_energy + secondary,
        energy_mJ=wear.energy_mJ + cycles * float(pairing.areas @ energy),
    )
