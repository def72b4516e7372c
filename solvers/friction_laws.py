"""All friction laws there are: those of the library and those that installed packages add."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from functools import cache

from solvers.errors import SolverError
from solvers.friction_law import Coulomb, FrictionLaw
from solvers.plugins import installed
from solvers.shear_limited_friction import ShearLimited

#: Entry point group in which a package names its subclasses of `FrictionLaw`.
ENTRY_POINT_GROUP = "wirewear.friction_laws"

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
