"""Two bodies pressed together by a holder, and how their surfaces face each other.

A pairing couples k nodes of the primary body, which carries the tractions, with the surface of the secondary body that
faces them. The core is the set of nodes that have stuck ever since the bodies were pressed together. A drive is the
displacement in mm of the lower body along x; offsets are positions in the plane of contact.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import pi, tan
from typing import Literal

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.contact_conditions import ContactAlgorithm
from solvers.contact_state import ContactState, DriveTiming, Holder, WearState
from solvers.elasticity.pairing import Pairing, PrimarySurface, pair, primary_surface, vertical_gap
from solvers.elasticity.placement import PlacedBody, interpolated
from solvers.errors import SolverError
from solvers.laws.debris import DebrisFlow
from solvers.laws.friction_law import Coulomb, Friction, FrictionLaw
from solvers.laws.layers import ContactLayer, retained_share
from solvers.laws.local_state import LocalField, LocalState
from solvers.laws.yielding import PressureLimit
from solvers.newton import SemismoothNewton
from solvers.wear import WearRates

Formulation = Literal["augmented-lagrangian", "penalty"]  #: How contact conditions are imposed.


@dataclass(frozen=True)
class ContactProblem:
    """Two bodies, the holder of the upper one, and the laws between them.

    The primary, whose patch carries the tractions, is the upper body if primary_is_upper, else the lower one. Raises
    SolverError for a negative coefficient of friction.
    """

    upper: PlacedBody
    lower: PlacedBody
    holder: Holder
    friction: float  #: Coefficient of friction.
    wear: WearRates  #: The wear law, with both bodies' coefficients.
    primary_is_upper: bool = True
    #: "augmented-lagrangian" holds gaps and stick exactly; "penalty" puts an elastic layer between the bodies,
    #: `layer_mm_per_MPa` soft in all directions, whose compliance is a small share of a node's own.
    formulation: Formulation = "augmented-lagrangian"
    layers: tuple[ContactLayer, ...] = ()  #: Physical layers between the surfaces, in series.
    debris: DebrisFlow | None = None  #: How debris that layers retain leaves, in cycle jumps; None: none leaves.
    limit: PressureLimit | None = None  #: Pressure at which the surfaces yield; None for elastic bodies.
    friction_law: FrictionLaw = field(default_factory=Coulomb)  #: The law to which `friction` belongs.
    timing: DriveTiming = field(default_factory=DriveTiming)  #: The drive over time, for laws that need speeds.
    fields: Mapping[str, LocalField] = field(default_factory=dict)  #: Further local fields, see `LocalState`.
    algorithm: ContactAlgorithm = field(default_factory=SemismoothNewton)  #: Solves the conditions of an increment.
    cycle: float = 0.0  #: Number of cycles done, for laws that depend on it.
    retained: float = field(init=False)  #: Share of worn depths that becomes debris in the layers.
    surface: PrimarySurface = field(init=False, repr=False)  #: The primary's, for pairing.
    layer_mm_per_MPa: float = field(init=False)  #: Compliance of the penalty's layer; 0 without one.

    def __post_init__(self) -> None:
        if self.friction < 0.0:
            raise SolverError(f"the friction coefficient must not be negative, but is {self.friction}")
        object.__setattr__(self, "retained", retained_share(self.layers))
        object.__setattr__(self, "surface", primary_surface(self.primary))
        # Of the nodes' own compliance; penetration is then about 1 % of the approach on usual meshes.
        layer = 0.02 * float(self.nodal_compliance[2]) if self.formulation == "penalty" else 0.0
        object.__setattr__(self, "layer_mm_per_MPa", layer)

    @property
    def nodal_compliance(self) -> Array:
        """Displacements (3,) of a typical node of both surfaces together by a unit traction on its own area, mm per
        MPa.
        """
        return self.upper.nodal_compliance + self.lower.nodal_compliance

    @cached_property
    def law(self) -> Friction:
        """The friction law with its coefficient, of surfaces that neither slide nor have slid."""
        return Friction(self.friction, self.friction_law)

    def forget(self) -> None:
        """Drop matrices and pairings that were kept from earlier increments."""
        for body in (self.primary, self.secondary):
            body.forget()

    def law_at(self, local: LocalState) -> Friction:
        """The friction law with the coefficients (k,) that the local state at k nodes gives."""
        factor = self.friction_law.factor(local) * self.wear.friction_factor(local)
        return Friction(self.friction * factor, self.friction_law, local=local)

    def bedded(self, wear: WearState) -> tuple[Array, Array]:
        """Worn depths in mm of (primary, secondary) whose debris is still there, for layers; all where none leaves."""
        if wear.primary_debris is None or self.retained == 0.0:
            return wear.depths
        primary, secondary = (thickness / self.retained for thickness in wear.debris(self.retained))
        return primary, secondary

    def stretched(self, step: Array, nodes: IntArray, offset: Array) -> Array:
        """Motion (k, 3) in mm of the upper relative to the lower surface at nodes of the primary by a change of bulk
        strain.

        step: (2, 2, 2) change of displacement gradients, see `ContactState.bulk`.  offset: (2,) position in mm of the
        secondary relative to the primary. Each surface stretches about its body's origin, the centre of the contact.
        """
        own = self.primary.node_positions[nodes]
        lower, upper = (own - offset, own) if self.primary_is_upper else (own, own - offset)
        moved = np.zeros((len(nodes), 3))
        for body, places, gradient, sign in ((self.upper, upper, step[1], 1.0), (self.lower, lower, step[0], -1.0)):
            moved[:, :2] += sign * places @ body.world_to_patch.T @ gradient.T @ body.world_to_patch
        return moved

    @property
    def unchanging(self) -> bool:
        """True if cycles change neither surfaces nor friction: no wear, and a law without memory or temperature."""
        warms = self.wear.heat is not None and self.wear.heat.friction_per_K != 0.0
        return self.wear.none and not (self.friction_law.remembers or warms)

    @cached_property
    def yields(self) -> bool:
        """True if a body of a class that yields by itself takes part; `limit` does not count."""
        return self.upper.yielding is not None or self.lower.yielding is not None

    @property
    def primary(self) -> PlacedBody:
        return self.upper if self.primary_is_upper else self.lower

    @property
    def secondary(self) -> PlacedBody:
        return self.lower if self.primary_is_upper else self.upper

    @cached_property
    def smallest_element(self) -> float:
        return min(self.upper.patch.smallest_element, self.lower.patch.smallest_element)

    def offset(self, drive: float, holder_x: float) -> Array:
        """Plane position (2,) in mm of the secondary body's origin relative to the primary's, for a drive and a
        holder's position, both in mm.
        """
        ahead = drive - holder_x
        return np.array([ahead if self.primary_is_upper else -ahead, 0.0])


def unloaded_state(problem: ContactProblem) -> ContactState:
    """The state of unworn bodies that just touch, at mid-stroke, with the holder at 0."""
    primary, secondary = problem.primary.patch, problem.secondary.patch
    wear = WearState(
        primary_depth=np.zeros(primary.shape),
        secondary_depth=np.zeros(secondary.shape),
        primary_energy=np.zeros(primary.shape),
        secondary_energy=np.zeros(secondary.shape),
        primary_print=np.zeros(primary.shape) if problem.limit or problem.primary.yielding else None,
        secondary_print=np.zeros(secondary.shape) if problem.limit or problem.secondary.yielding else None,
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


def recoated(problem: ContactProblem, wear: WearState) -> ContactProblem:
    """The problem with what wear has left of coatings in the compliance; itself if that has not changed."""
    primary, secondary = problem.primary, problem.secondary
    if primary.coats is None:
        return problem
    nodes, weights, _ = secondary.patch.locate(primary.node_positions @ secondary.world_to_patch.T)
    facing_mm = interpolated(wear.secondary_depth.ravel(), nodes, weights)
    now = primary.worn_through(wear.primary_depth, facing_mm)
    if now is primary:
        return problem
    return replace(problem, upper=now) if problem.primary_is_upper else replace(problem, lower=now)


def misaligned(problem: ContactProblem, angle_rad: float) -> ContactProblem:
    """The problem with the motion tilted out of the plane of contact; a positive angle lifts the holder as x grows.

    x stays the direction of motion and z the load's at right angles to it. In these axes the plane of contact descends
    by tan(angle) along x: both surfaces are sheared by it, which is exact for the geometry; the bodies' compliance is
    unchanged, an error of the order of the angle in elastic displacements alone. Sliding under a dead weight takes Q =
    P tan(angle + phi) on the way out and P tan(angle - phi) on the way back, with tan(phi) the friction coefficient:
    their mean is P tan(angle) (1 + mu^2) to first order. A loading spring adds a ripple of its stiffness times
    tan(angle) times the drive.

    Raises SolverError if the angle is not between -30 and 30 degrees.
    """
    if not abs(angle_rad) < pi / 6.0:
        raise SolverError(f"the misalignment must lie between -30 and 30 degrees, but is {angle_rad} rad")
    descent = -tan(angle_rad)
    return replace(
        problem, upper=replace(problem.upper, incline=descent), lower=replace(problem.lower, incline=descent)
    )


def open_depths(problem: ContactProblem, state: ContactState) -> tuple[Array, Array]:
    """Depths (n_a, n_t) in mm by which the surfaces of (primary, secondary) have receded: worn depths, less what debris
    fills, plus prints.
    """
    bodies, depths = (problem.primary, problem.secondary), state.wear.opened(problem.retained)
    primary, secondary = (
        depth if pressed is None else body.receded(depth, pressed)
        for body, depth, pressed in zip(bodies, depths, state.wear.prints, strict=True)
    )
    return primary, secondary


def with_prints(problem: ContactProblem, state: ContactState, forces: tuple[Array, Array]) -> ContactState:
    """The state with the prints of bodies that yield, by nodal forces (n, 3) in N on the (primary, secondary)."""
    wear = state.wear
    primary = problem.primary.printed(wear.primary_print, forces[0])
    secondary = problem.secondary.printed(wear.secondary_print, forces[1])
    return replace(state, wear=replace(wear, primary_print=primary, secondary_print=secondary))


def vertical_gaps(problem: ContactProblem, state: ContactState, drive: float, holder_x: float) -> Array:
    """Gaps (n,) in mm along z of the undeformed surfaces at the primary's nodes with the holder at height 0, negative
    where they overlap; infinite where no secondary patch faces a node. drive, holder_x: displacement of the lower body
    and position of the upper one's holder, mm.
    """
    offset = facing_offset(problem, state, drive, holder_x)
    upright = vertical_gap(problem.surface, problem.secondary, offset, *open_depths(problem, state))
    return upright + state.holder_tilt * levers(problem, drive, holder_x)


def facing_offset(problem: ContactProblem, state: ContactState, drive: float, holder_x: float) -> Array:
    """Plane position (2,) in mm of the secondary body's origin relative to the primary's at which surfaces are paired,
    for a drive and a holder's position in mm.

    While there is a core, its strain makes up for the bodies' motion: the surfaces stay paired as they were pressed
    together, so that depth worn beside the core is not moved over it.
    """
    if state.core.any():
        return problem.offset(state.pressed_ahead, 0.0)
    return problem.offset(drive, holder_x)


def faced(
    problem: ContactProblem, state: ContactState, nodes: IntArray, drive: float, holder_x: float, tilt: float
) -> Pairing:
    """The pairing of the primary's nodes (k,) with the secondary's surface as worn in a state; around a core the
    surfaces stay paired as they were pressed together.

    drive, holder_x, tilt: displacement of the lower body, position and tilt of the holder, mm and rad.
    """
    offset, depths = facing_offset(problem, state, drive, holder_x), open_depths(problem, state)
    if not state.core.any():
        return pair(problem.surface, problem.secondary, nodes, offset, *depths, tilt)
    latest, key = problem.primary.latest_pairing, (nodes, state.core, offset, np.array([tilt]))
    bodies = problem.secondary, *depths
    if not latest or not (
        all(one is other for one, other in zip(latest[0][0], bodies, strict=True))
        and all(np.array_equal(one, other) for one, other in zip(latest[0][1], key, strict=True))
    ):
        latest[:] = [(bodies, key, _around_core(problem, state, nodes, offset, depths, tilt))]
    pairing: Pairing = latest[0][2]
    # What strain makes up for is motion along the surfaces, up and down their slope.
    moved = holder_x - drive + state.pressed_ahead
    return replace(pairing, gap=pairing.gap + pairing.gap_rate * moved)


def _around_core(
    problem: ContactProblem,
    state: ContactState,
    nodes: IntArray,
    offset: Array,
    depths: tuple[Array, Array],
    tilt: float,
) -> Pairing:
    """The pairing around a core as the bodies were pressed together, at their `offset` (2,) then, worn to `depths`."""
    pairing = pair(problem.surface, problem.secondary, nodes, offset, *depths, tilt, at_nodes=True)
    # What sticks stands as it stood: what has worn beside the core must neither open it, as it would where a node lies
    # between one of the other body that sticks and one that has worn, nor turn its normals.
    sticks = np.flatnonzero(state.core[nodes])
    facing = pairing.depths.at_heaviest(sticks)
    faced_depth = facing.averaged(depths[1].ravel()) / pairing.areas
    opened = faced_depth - pairing.depths.averaged(depths[1].ravel()) / pairing.areas
    inside = _no_deeper(depths[0], depths[0].ravel()[nodes[sticks]]), _no_deeper(depths[1], faced_depth[sticks])
    frames = pairing.frames.copy()
    frames[sticks] = pair(problem.surface, problem.secondary, nodes[sticks], offset, *inside, tilt).frames
    rate = frames[:, 0, 0] / frames[:, 0, 2]
    return replace(pairing, frames=frames, gap=pairing.gap + opened, gap_rate=rate, depths=facing)


def _no_deeper(depth: Array, core: Array) -> Array:
    """Worn depths (n_a, n_t), limited to the largest in the core."""
    return np.asarray(np.minimum(depth, core.max(initial=0.0)))


def levers(problem: ContactProblem, drive: float, holder_x: float) -> Array:
    """Distance (n,) in mm along x of all the primary's nodes ahead of the holder's pivot, for a drive and a holder's
    position in mm.
    """
    along = problem.primary.node_positions[:, 0]
    return along if problem.primary_is_upper else along - problem.offset(drive, holder_x)[0]
