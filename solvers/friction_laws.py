"""All friction laws there are: those of the library and those that installed packages add."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields
from functools import cache
from importlib.metadata import entry_points
from inspect import isabstract
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from solvers.errors import SolverError
from solvers.friction_law import Coulomb, FrictionLaw


def installed(
    group: str, base: type[Any], noun: str, home: str, needed: tuple[str, ...], problem: Callable[[str], Exception]
) -> Iterator[tuple[str, Any]]:
    """Place ("package.module:Name") and class of each entry point of a group, by the entry points' names.

    Args:
        group: the entry points' group.
        base: what each class must be a subclass of; it is abstract, which mypy forbids of a type[Kind].
        noun: what such a class is to the user ("effect"), for messages.
        home: package from which users import the base class, for messages.
        needed: attributes that each class must have.
        problem: makes the error that is raised from one clear sentence without its full stop.

    Raises:
        Exception: what ``problem`` makes: an entry point cannot be loaded, or holds no such class, or one that lacks
            an attribute.
    """
    for point in sorted(entry_points(group=group), key=lambda point: point.name):
        try:
            kind = point.load()
        except Exception as failure:
            # Code of others may raise anything.
            reason = f"{type(failure).__name__}: {failure}".splitlines()[0]
            raise problem(
                f"the {noun} {point.name!r} of an installed package cannot be loaded from {point.value} ({reason}): "
                "mend or uninstall that package"
            ) from failure
        if not (isinstance(kind, type) and issubclass(kind, base)) or isabstract(kind):
            raise problem(
                f"the entry point {point.value} in the group {group} must be a subclass of "
                f"{home}.{base.__name__} that can be made"
            )
        missing = [name for name in needed if not hasattr(kind, name)]
        if missing:
            raise problem(f"the {noun} at the entry point {point.value} lacks {', '.join(missing)}")
        yield point.value, kind


Array = NDArray[np.float64]

#: Entry point group in which a package names its subclasses of `FrictionLaw`.
ENTRY_POINT_GROUP = "wirewear.friction_laws"


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


LIBRARY: tuple[type[FrictionLaw], ...] = (Coulomb, ShearLimited)


@cache
def friction_laws() -> Mapping[str, type[FrictionLaw]]:
    """Every law by its name: the library's, then those of installed packages.

    Raises:
        SolverError: a package's entry point holds no law, or one whose name is taken.
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

    Raises:
        SolverError: there is none, or it has other parameters, or they cannot be.
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
