"""What laws of friction and wear may know of the places where two surfaces meet, each field by its name.

A law asks for the fields that it needs; what none asks for is never worked out. Beside those of `LocalState` a problem
may have fields of its own (`ContactProblem.fields`), worked out from the others: a temperature from pressure and
speed, say. Neither solver needs to know of them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.contact_state import WearState
from solvers.errors import SolverError


class LocalField(Protocol):
    """A field that a problem has besides, by the name under which laws ask for it."""

    def at(self, local: "LocalState", /) -> Array:
        """Its values at the k nodes, (k,), from the fields that they have already."""
        ...


@dataclass(frozen=True)
class LocalState:
    """k nodes of the primary as they face the secondary; nothing is worked out before a law asks for it."""

    wear: WearState  #: Of both bodies.
    of_primary: Callable[[Array], Array]  #: Takes a field (n,) of its patch to the nodes, (k,), as the next.
    of_secondary: Callable[[Array], Array]
    sliding: Callable[[], Array]  #: Their speeds (k,), mm/s.
    pressing: Callable[[], Array]  #: Pressures (k,) on them as they are known, MPa.
    primary_is_upper: bool
    cycle: float = 0.0  #: Cycles done before, known to laws that age.
    fields: Mapping[str, LocalField] = field(default_factory=dict)  #: Further ones by name.

    @property
    def speed_mm_per_s(self) -> Array:
        """Sliding speed (k,); 0 where a node sticks."""
        return self.sliding()

    @property
    def pressure_MPa(self) -> Array:
        """Pressure (k,) of the latest iteration; what friction and wear do with the pressure itself is in limits."""
        return self.pressing()

    @property
    def worn_depth_mm(self) -> Array:
        """Depth (k,) to which both surfaces together have worn."""
        primary, secondary = (depth.ravel() for depth in self.wear.depths)
        return self.of_primary(primary) + self.of_secondary(secondary)

    @property
    def energy_mJ_per_mm2(self) -> Array:
        """Friction energy (k,) per plane area that the surfaces have taken so far, as a mean of both."""
        primary, secondary = (energy.ravel() for energy in (self.wear.primary_energy, self.wear.secondary_energy))
        return 0.5 * (self.of_primary(primary) + self.of_secondary(secondary))

    def __getitem__(self, name: str) -> Array:
        """A further field (k,) by its name. Raises SolverError if the problem has none of that name."""
        if name not in self.fields:
            known = ", ".join(self.fields) or "none"
            raise SolverError(f"a law asks for the local field {name!r}, but the contact has {known}")
        return np.asarray(self.fields[name].at(self))

    def among(self, chosen: slice | IntArray) -> "LocalState":
        """The state at chosen nodes alone."""
        return replace(
            self,
            of_primary=lambda nodal: self.of_primary(nodal)[chosen],
            of_secondary=lambda nodal: self.of_secondary(nodal)[chosen],
            sliding=lambda: self.sliding()[chosen],
            pressing=lambda: self.pressing()[chosen],
        )
