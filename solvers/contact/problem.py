"""Two bodies pressed together by a holder, the laws between them, and their state before any load."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from math import pi, tan
from typing import Literal

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.contact_layer import ContactLayer, open_share
from solvers.contact_state import ContactState, Holder, WearState
from solvers.errors import SolverError
from solvers.friction_law import Coulomb, Friction, FrictionLaw
from solvers.local_state import DriveTiming, LocalState
from solvers.pairing import PrimarySurface, primary_surface
from solvers.placement import PlacedBody
from solvers.wear import WearRates

_PENALTY_SHARE = 0.02  # Of the nodes' own compliance; penetration is then about 1 % of the approach on usual meshes.
Formulation = Literal["augmented-lagrangian", "penalty"]  #: How contact conditions are imposed.


@dataclass(frozen=True)
class ContactProblem:
    """Two bodies, the holder of the upper one, and the laws between them.

    `primary` is the body whose patch carries the tractions; either of the two may be.
    formulation: "augmented-lagrangian" holds gaps and stick exactly; "penalty" puts an elastic layer between the
    bodies, `layer_mm_per_MPa` soft in all directions, whose compliance is a small share of a node's own.
    friction: its coefficient, which effects change.  friction_law: what it is the coefficient of.
    layers: physical ones between the surfaces, in series.  timing: of the drive, for laws that ask for speeds.
    """

    upper: PlacedBody
    lower: PlacedBody
    holder: Holder
    friction: float
    wear: WearRates
    primary_is_upper: bool = True
    formulation: Formulation = "augmented-lagrangian"
    layers: tuple[ContactLayer, ...] = ()
    friction_law: FrictionLaw = field(default_factory=Coulomb)
    timing: DriveTiming = field(default_factory=DriveTiming)
    surface: PrimarySurface = field(init=False, repr=False)
    layer_mm_per_MPa: float = field(init=False)

    def __post_init__(self) -> None:
        if self.friction < 0.0:
            raise SolverError(f"the friction coefficient must not be negative, but is {self.friction}")
        open_share(self.layers)
        object.__setattr__(self, "surface", primary_surface(self.primary))
        layer = _PENALTY_SHARE * self._nodal_compliance() if self.formulation == "penalty" else 0.0
        object.__setattr__(self, "layer_mm_per_MPa", layer)

    def _nodal_compliance(self) -> float:
        """Displacement of a typical node of both surfaces by unit pressure on its own area, mm per MPa."""
        return sum(
            float(np.median(body.folded.diagonal()[2::3] * body.patch.node_areas()))
            for body in (self.upper, self.lower)
        )

    @cached_property
    def law(self) -> Friction:
        """The friction law with its coefficient, as it is where nothing slides or has slid."""
        return Friction(self.friction, self.friction_law)

    def law_at(self, local: LocalState) -> Friction:
        """The friction law as it is at k nodes."""
        factor = self.friction_law.factor(local) * self.wear.friction_factor(local)
        return Friction(self.friction * factor, self.friction_law)

    def stretched(self, step: Array, nodes: IntArray, offset: Array) -> Array:
        """Motion (k, 3) of the upper against the lower surface at nodes of the primary by a step of bulk strain.

        step: (2, 2, 2) of displacement gradients, see `ContactState`.  offset: (2,) where the bodies face each other.
        Each surface stretches about its body's origin, the contact's centre.
        """
        own = self.primary.node_positions[nodes]
        lower, upper = (own - offset, own) if self.primary_is_upper else (own, own - offset)
        moved = np.zeros((len(nodes), 3))
        for body, places, gradient, sign in ((self.upper, upper, step[1], 1.0), (self.lower, lower, step[0], -1.0)):
            moved[:, :2] += sign * places @ body.world_to_patch.T @ gradient.T @ body.world_to_patch
        return moved

    @property
    def unchanging(self) -> bool:
        """Whether cycles leave the surfaces as they are."""
        return self.wear.none and not self.friction_law.remembers

    @property
    def primary(self) -> PlacedBody:
        """The body that carries the tractions."""
        return self.upper if self.primary_is_upper else self.lower

    @property
    def secondary(self) -> PlacedBody:
        return self.lower if self.primary_is_upper else self.upper

    @cached_property
    def smallest_element(self) -> float:
        """Smallest spacing of grid lines on either patch, mm."""
        return min(self.upper.patch.smallest_element, self.lower.patch.smallest_element)

    def offset(self, drive: float, holder_x: float) -> Array:
        """Plane position of the secondary body's origin relative to the primary's, shape (2,)."""
        ahead = drive - holder_x
        return np.array([ahead if self.primary_is_upper else -ahead, 0.0])


def unloaded_state(problem: ContactProblem) -> ContactState:
    """Fresh bodies that just touch."""
    primary, secondary = problem.primary.patch, problem.secondary.patch
    wear = WearState(
        primary_depth=np.zeros(primary.shape),
        secondary_depth=np.zeros(secondary.shape),
        primary_energy=np.zeros(primary.shape),
        secondary_energy=np.zeros(secondary.shape),
    )
    return ContactState(
        wear=wear,
        drive=0.0,
        holder_x=0.0,
        holder_z=0.0,
        holder_tilt=0.0,
        holder_rate=1.0,
        overlap_area=0.0,
        pressed_z=float("nan"),
        traction=np.zeros((primary.size, 3)),
        primary_force=np.zeros((primary.size, 3)),
        secondary_force=np.zeros((secondary.size, 3)),
        primary_slid=np.zeros(primary.size),
        secondary_slid=np.zeros(secondary.size),
        core=np.zeros(primary.size, dtype=bool),
        pressed_ahead=0.0,
        slip_share=np.zeros(primary.size),
    )


def misaligned(problem: ContactProblem, angle_rad: float) -> ContactProblem:
    """The problem with the motion tilted out of the contact plane; a positive angle lifts the holder as x grows.

    Forces stay those along the motion (x) and the load's axis at right angles to it (z), in which the plane of contact
    descends by tan(angle) along x: both surfaces are sheared by it, which is exact for the contact's geometry and
    leaves the bodies' compliance as it was, an error of the order of the angle in the elastic displacements alone.
    Sliding under a dead weight takes Q = P tan(angle + phi) on the way out and P tan(angle - phi) on the way back, with
    tan(phi) the friction coefficient: their mean is P tan(angle) (1 + mu^2) to first order, P tan(angle) without
    friction. A loading spring adds a ripple of its stiffness times tan(angle) times the drive.
    Raises SolverError if the angle is not between -30 and 30 degrees.
    """
    if not abs(angle_rad) < pi / 6.0:
        raise SolverError(f"the misalignment must lie between -30 and 30 degrees, but is {angle_rad} rad")
    descent = -tan(angle_rad)
    return replace(
        problem, upper=replace(problem.upper, incline=descent), lower=replace(problem.lower, incline=descent)
    )
