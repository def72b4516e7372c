"""Friction laws: which tangential traction a contact transmits at most before it slides, at the pressure on it.

Newton's method asks a law for its limit and for the limit's derivative by the pressure; friction work is the limit
times the slip. A law stands in a file of its own and is named in `LIBRARY`, or in the entry point group
"wirewear.friction_laws" of an installed package; a study chooses it by its name.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from geometry.arrays import Array


@dataclass(frozen=True)
class FrictionLaw(ABC):
    """A law as a study describes it: its parameters are the fields of a frozen dataclass.

    name: by which studies choose it.  The coefficient of friction is no parameter of the law but an argument, for tests
    and effects change it: it is the limit's slope at vanishing pressure.
    proportional: whether the limit is the coefficient times the pressure; what follows is then not computed anew.
    """

    name: ClassVar[str]
    proportional: ClassVar[bool] = False

    @abstractmethod
    def limit(self, friction: float, pressure_MPa: Array, /) -> Array:
        """Largest tangential traction (k,), MPa, under pressures of at least 0."""

    @abstractmethod
    def derivative(self, friction: float, pressure_MPa: Array, /) -> Array:
        """Derivative (k,) of the limit by the pressure; not negative."""


@dataclass(frozen=True)
class Coulomb(FrictionLaw):
    """Amontons' and Coulomb's law: friction in proportion to the pressure."""

    name: ClassVar[str] = "coulomb"
    proportional: ClassVar[bool] = True

    def limit(self, friction: float, pressure_MPa: Array, /) -> Array:
        """Coefficient times pressure."""
        return friction * pressure_MPa

    def derivative(self, friction: float, pressure_MPa: Array, /) -> Array:
        """The coefficient."""
        return np.full_like(pressure_MPa, friction)


@dataclass(frozen=True)
class Friction:
    """A law with a coefficient of friction, as the contact's equations see it; tractions are those on the surface."""

    coefficient: float
    law: FrictionLaw = field(default_factory=Coulomb)

    @property
    def none(self) -> bool:
        """Whether the contact is frictionless."""
        return self.coefficient == 0.0

    def limit(self, pressure_MPa: Array) -> Array:
        """Largest tangential traction (k,) at pressures (k,), MPa; none under tension, which Newton may try."""
        return self.law.limit(self.coefficient, np.maximum(pressure_MPa, 0.0))

    def derivative(self, pressure_MPa: Array) -> Array:
        """Derivative (k,) of the limit by the pressure, under tension that at no pressure."""
        return self.law.derivative(self.coefficient, np.maximum(pressure_MPa, 0.0))

    def tangent(self, pressure_MPa: Array) -> tuple[Array, Array]:
        """The limit's straight tangent: its slope (k,), and its value (k,) extrapolated to no pressure."""
        if self.law.proportional:
            return np.full_like(pressure_MPa, self.coefficient), np.zeros_like(pressure_MPa)
        slope, pressure = self.derivative(pressure_MPa), np.maximum(pressure_MPa, 0.0)
        return slope, self.limit(pressure) - slope * pressure
