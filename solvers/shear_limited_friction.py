"""Friction that the softer surface's shear strength limits where the pressure is high."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from solvers.errors import SolverError
from solvers.friction_law import FrictionLaw

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ShearLimited(FrictionLaw):
    """tau = k (1 - exp(-mu p / k)): Coulomb's law at low pressure, the shear strength k at high.

    Usui & Shirakashi, Mechanics of machining, from descriptive to predictive theory, ASME PED 7 (1982) 13. At high
    pressure asperities merge and the real area of contact can grow no more.

    shear_strength_MPa: k, of the softer surface or of the film on it.

    Raises:
        SolverError: the strength is not positive.
    """

    name: ClassVar[str] = "shear-limited"

    shear_strength_MPa: float

    def __post_init__(self) -> None:
        if not self.shear_strength_MPa > 0.0:
            raise SolverError(f"the shear strength must be positive, but is {self.shear_strength_MPa} MPa")

    def limit(self, friction: float, pressure_MPa: Array, /) -> Array:
        """Coefficient times pressure, bent towards the shear strength."""
        return -self.shear_strength_MPa * np.expm1(-friction * pressure_MPa / self.shear_strength_MPa)

    def derivative(self, friction: float, pressure_MPa: Array, /) -> Array:
        """The coefficient, which dies away with the pressure."""
        return friction * np.exp(-friction * pressure_MPa / self.shear_strength_MPa)
