"""The local state of a contact: fields at its nodes on which laws of friction and wear may depend, each with a name.

A field is computed when a law asks for it, otherwise not. In addition to the fields of `LocalState` a contact problem
may have fields of its own (`ContactProblem.fields`), computed from the others: a temperature from pressure and speed,
say. The solvers need not be changed for them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.contact_state import WearState
from solvers.errors import SolverError


class LocalField(Protocol):
    """A quantity at contact nodes that users add to `ContactProblem.fields` and laws read by name, as a temperature."""

    def at(self, local: "LocalState", /) -> Array:
        """Values (k,) of the field at the k nodes, from the other fields of the local state."""
        ...


@dataclass(frozen=True)
class LocalState:
    """Fields at k nodes of the primary body, which carries the tractions, as they face the secondary body."""

    wear: WearState  #: Worn depths and friction energies of both bodies.
    #: From a field (n,) on a body's patch to its values at the nodes, (k,).
    of_primary: Callable[[Array], Array]
    of_secondary: Callable[[Array], Array]  #: Likewise of the secondary's patch: mean over what each node faces.
    sliding: Callable[[], Array]  #: Sliding speeds (k,), mm/s.
    pressing: Callable[[], Array]  #: Pressures (k,) of the latest iteration, MPa.
    primary_is_upper: bool
    cycle: float = 0.0  #: Number of cycles done before.
    fields: Mapping[str, LocalField] = field(default_factory=dict)  #: Fields of the contact problem by name.

    @property
    def speed_mm_per_s(self) -> Array:
        """Sliding speed (k,); 0 where a node sticks."""
        return self.sliding()

    @property
    def pressure_MPa(self) -> Array:
        """Pressure (k,) of the latest iteration. A law's dependence on pressure belongs in its `limit`, which Newton's
        method differentiates.
        """
        return self.pressing()

    @property
    def worn_depth_mm(self) -> Array:
        """Worn depth (k,) of both surfaces together."""
        primary, secondary = (depth.ravel() for depth in self.wear.depths)
        return self.of_primary(primary) + self.of_secondary(secondary)

    @property
    def energy_mJ_per_mm2(self) -> Array:
        """Friction energy (k,) per plane area that has been dissipated so far, mean of both surfaces."""
        primary, secondary = (energy.ravel() for energy in (self.wear.primary_energy, self.wear.secondary_energy))
        return 0.5 * (self.of_primary(primary) + self.of_secondary(secondary))

    @property
    def rise_K(self) -> Array:
        """Rise (k,) of the temperature by friction, mean of both surfaces; 0 before the first cycle jump."""
        if (rises := self.wear.rises) is None:
            return np.zeros_like(self.pressing())
        return 0.5 * (self.of_primary(rises[0].ravel()) + self.of_secondary(rises[1].ravel()))

    def __getitem__(self, name: str) -> Array:
        """A field (k,) of the contact problem by its name. Raises SolverError if the problem has no such field."""
        if name not in self.fields:
            known = ", ".join(self.fields) or "none"
            raise SolverError(f"a law asks for the local field {name!r}, but the contact has {known}")
        return np.asarray(self.fields[name].at(self))

    def among(self, chosen: slice | IntArray) -> "LocalState":
        """The local state at the nodes of these indices into the k."""
        return replace(
            self,
            of_primary=lambda nodal: self.of_primary(nodal)[chosen],
            of_secondary=lambda nodal: self.of_secondary(nodal)[chosen],
            sliding=lambda: self.sliding()[chosen],
            pressing=lambda: self.pressing()[chosen],
        )
