"""Friction laws: which tangential traction a contact transmits at most before it slides, at the pressure on it.

Newton's method asks a law for its limit and for the limit's derivative by the pressure; friction work is the limit
times the slip. A law stands in a file of its own and is named in `LIBRARY`, or in the entry point group
"wirewear.friction_laws" of an installed package; a study chooses it by its name.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from typing import ClassVar

import numpy as np

from geometry.arrays import Array
from solvers.errors import SolverError
from solvers.plugins import installed


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


#: Entry point group in which a package names its subclasses of `FrictionLaw`.
ENTRY_POINT_GROUP = "wirewear.friction_laws"


@dataclass(frozen=True)
class ShearLimited(FrictionLaw):
    """tau = k (1 - exp(-mu p / k)): Coulomb's law at low pressure, the shear strength k at high.

    Usui & Shirakashi, Mechanics of machining, from descriptive to predictive theory, ASME PED 7 (1982) 13. At high
    pressure asperities merge and the real area of contact can grow no more.

    shear_strength_MPa: k, of the softer surface or of the film on it.
    Raises SolverError if the strength is not positive.
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


LIBRARY: tuple[type[FrictionLaw], ...] = (Coulomb, ShearLimited)


@cache
def friction_laws() -> Mapping[str, type[FrictionLaw]]:
    """Every law by its name: the library's, then those of installed packages.
    Raises SolverError if a package's entry point holds no law, or one whose name is taken.
    """
    found = {law.name: law for law in LIBRARY}
    for place, law in installed(ENTRY_POINT_GROUP, FrictionLaw, "friction law", "solvers", ("name",), SolverError):
        if law.name in found:
            raise SolverError(
                f"the entry point {place} adds a friction law named {law.name!r}, but there is one of that name "
                "already: uninstall that package, or give its law another name"
            )
        found[law.name] = law
    return found


def friction_law(name: str, parameters: Mapping[str, float]) -> FrictionLaw:
    """The law of that name with these parameters.
    Raises SolverError if there is none, or it has other parameters, or they cannot be.
    """
    if name not in friction_laws():
        raise SolverError(f"there is no friction law {name!r}; the laws are {', '.join(map(repr, friction_laws()))}")
    law = friction_laws()[name]
    wanted = [parameter.name for parameter in fields(law)]
    if sorted(parameters) != sorted(wanted):
        given = f"but is given {', '.join(parameters)}" if parameters else "but is given none"
        takes = f"takes {', '.join(wanted)}" if wanted else "takes no parameters"
        raise SolverError(f"the friction law {name!r} {takes}, {given}")
    return law(**parameters)
