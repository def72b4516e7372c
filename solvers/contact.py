"""Frictional contact of two condensed bodies: one increment of a finite-sliding motion, solved by semismooth Newton.

Unknowns are the tractions on the primary surface and the holder's position along the normal and the motion. The
augmented-Lagrangian conditions of Alart & Curnier (Comput. Methods Appl. Mech. Eng. 92 (1991) 353) decide node by
node between open, stick and slip. Slipping nodes that move far compared with their elastic displacement follow a
known direction and cost one unknown; the others keep their tangential unknowns. Wear during the increment recedes the
surfaces in proportion to pressure times slip, one more compliance in the normal equations, so any number of cycles
can be taken at once.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix, diags

from solvers.compliance import paired_compliance
from solvers.contact_layer import ContactLayer, LayersAtNodes, layers_at_nodes, open_share
from solvers.contact_state import ContactState, IncrementReport, WearState
from solvers.contact_system import LOST_CONTACT, Linearisation, NewtonOutcome
from solvers.errors import NotConvergedError, PatchLeftError, SolverError
from solvers.guide import Guess
from solvers.holder import Holder
from solvers.newton import solve_contact
from solvers.pairing import Pairing, PrimarySurface, pair, primary_surface, vertical_gap
from solvers.placement import PlacedBody
from solvers.wear import WearRates, deposited, worn_gap_operator

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# The pairing is renewed when the holder has moved by more than this share of the smallest element since; the gap's
# error is of second order in that distance.
_PAIRING_TOLERANCE = 0.15
_MOST_PAIRINGS = 12
# Nodes searched for contact make up this multiple of the area on which the undeformed bodies overlapped before.
_CANDIDATE_MARGIN = 1.15
_MOST_CUTS = 8
# Nodes this close to the friction limit, relative to it, count as slipping: normals turn a little between increments.
_STICK_MARGIN = 0.02
# Of the nodes' own compliance; penetration is then about 1 % of the approach on usual meshes.
_PENALTY_SHARE = 0.02

#: How contact conditions are imposed.
Formulation = Literal["augmented-lagrangian", "penalty"]


@dataclass(frozen=True)
class ContactProblem:
    """Two bodies, the holder of the upper one, and the laws between them.

    `primary` is the body whose patch carries the tractions; either of the two may be.
    formulation: "augmented-lagrangian" holds gaps and stick exactly; "penalty" puts an elastic layer between the
    bodies, `layer_mm_per_MPa` soft in all directions, whose compliance is a small share of a node's own.
    layers: physical ones between the surfaces, in series.
    """

    upper: PlacedBody
    lower: PlacedBody
    holder: Holder
    friction: float
    wear: WearRates
    primary_is_upper: bool = True
    formulation: Formulation = "augmented-lagrangian"
    layers: tuple[ContactLayer, ...] = ()
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
            float(np.median(np.diag(body.compliance)[2::3] * body.patch.node_areas()))
            for body in (self.upper, self.lower)
        )

    @property
    def primary(self) -> PlacedBody:
        """The body that carries the tractions."""
        return self.upper if self.primary_is_upper else self.lower

    @property
    def secondary(self) -> PlacedBody:
        """The other body."""
        return self.lower if self.primary_is_upper else self.upper

    @property
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
    )


def press(problem: ContactProblem, state: ContactState) -> tuple[ContactState, IncrementReport]:
    """Apply the normal load without friction and without motion."""
    frictionless = replace(problem, friction=0.0)
    if problem.holder.approach_mm is not None:
        lowered = replace(state, holder_z=-problem.holder.approach_mm, pressed_z=-problem.holder.approach_mm)
        return _solve(frictionless, lowered, state.drive, 0.0)
    height = _height_under_load(frictionless, state)
    start = replace(state, holder_z=height, pressed_z=height)
    rigid = replace(frictionless, holder=replace(problem.holder, normal_stiffness_N_per_mm=0.0))
    pressed, report = _solve(rigid, start, state.drive, 0.0)
    return replace(pressed, pressed_z=pressed.holder_z), report


def advance(
    problem: ContactProblem, state: ContactState, drive: float, cycles: float, guess: Guess | None = None
) -> tuple[ContactState, list[IncrementReport]]:
    """Move the lower body to `drive`, each bit of slip wearing as if repeated `cycles` times (0: wear frozen).

    guess: what a cycle before came to at this drive, a better first guess than the last increment.
    Cuts the increment where Newton's method does not converge; NotConvergedError when even tiny ones fail.
    """
    reports: list[IncrementReport] = []
    pieces = 1
    done = 0.0
    start, current = state.drive, state
    while done < 1.0 - 1e-12:
        share = min(1.0 / pieces, 1.0 - done)
        try:
            near = guess if done + share >= 1.0 - 1e-12 else None
            current, report = _solve(problem, current, start + (done + share) * (drive - start), cycles, expected=near)
        except _NotConvergedError as failure:
            pieces *= 2
            if pieces > 2**_MOST_CUTS:
                place = 1e3 * (start + done * (drive - start))
                raise NotConvergedError(
                    f"the contact did not converge at a displacement of {place:.3f} um, even in steps of "
                    f"1/{pieces // 2} increment: {failure}"
                ) from None
            continue
        done += share
        reports.append(report)
    return current, reports


class _NotConvergedError(Exception):
    """One increment failed; the message says how."""


class _LostContactError(_NotConvergedError):
    """Nothing touches."""


def _height_under_load(problem: ContactProblem, state: ContactState) -> float:
    """Height of the holder at which rigid interpenetration would carry about the load, as a first guess.

    Doubles the approach until a first Newton solution under prescribed height carries the load.
    """
    elastic = float(np.median(np.diag(problem.primary.compliance))) * problem.holder.normal_load_N
    # Bodies with a depth from the outset touch below the height at which unworn ones would.
    touch = max(float(_vertical_gaps(problem, state, state.drive, state.holder_x).min()), 0.0)
    approach = 0.1 * elastic
    for _ in range(60):
        height = -touch - approach
        guess = replace(state, holder_z=height, pressed_z=height)
        try:
            pressed, _report = _solve(problem, guess, state.drive, 0.0, prescribed_height=height)
        except _LostContactError:
            # One node alone touches before its whole support, on average, does.
            approach *= 1.6
            continue
        except _NotConvergedError:
            approach *= 0.5
            continue
        force = float(pressed.primary_force[:, 2].sum())
        if force > 0.3 * problem.holder.normal_load_N:
            return -touch - approach * float((problem.holder.normal_load_N / force) ** (2.0 / 3.0))
        approach *= 1.6
    raise SolverError("the bodies could not be pressed together: no contact found under the normal load")


def _open_depths(problem: ContactProblem, state: ContactState) -> tuple[Array, Array]:
    """Worn depth of the primary and the secondary body without what layers fill."""
    share = open_share(problem.layers)
    return share * state.wear.primary_depth, share * state.wear.secondary_depth


def _vertical_gaps(problem: ContactProblem, state: ContactState, drive: float, holder_x: float) -> Array:
    offset = problem.offset(drive, holder_x)
    upright = vertical_gap(problem.surface, problem.secondary, offset, *_open_depths(problem, state))
    return upright + state.holder_tilt * _levers(problem, drive, holder_x)


def _levers(problem: ContactProblem, drive: float, holder_x: float) -> Array:
    """Distance of the primary's nodes ahead of the holder's pivot, along x, shape (n,)."""
    along = problem.primary.node_positions[:, 0]
    return along if problem.primary_is_upper else along - problem.offset(drive, holder_x)[0]


def _closest(gap: Array, areas: Array, area: float) -> IntArray:
    """The nodes with the smallest gaps that make up an area, at least a dozen."""
    order = np.argsort(gap, kind="stable")
    # The area is often the very sum that is searched for, added in another order: round-off must not decide.
    count = max(int(np.searchsorted(np.cumsum(areas[order]), area * (1.0 - 1e-9))) + 1, 12)
    chosen = order[:count]
    return np.sort(chosen[np.isfinite(gap[chosen])])


def _solve(
    problem: ContactProblem,
    state: ContactState,
    drive: float,
    cycles: float,
    prescribed_height: float | None = None,
    expected: Guess | None = None,
) -> tuple[ContactState, IncrementReport]:
    tolerance = _PAIRING_TOLERANCE * problem.smallest_element
    areas = problem.surface.areas
    holder_x = _predicted_holder_position(problem, state, drive) if expected is None else expected.holder_x
    tilt = state.holder_tilt + problem.holder.tilt_per_motion_rad_per_mm * (holder_x - state.holder_x)
    gap = _vertical_gaps(problem, state, drive, holder_x)
    old_area = float(areas[state.traction[:, 2] > 0.0].sum())
    if expected is not None:
        active = np.flatnonzero(expected.traction[:, 2] > 0.0)
        nodes = np.union1d(active, _closest(gap, areas, _CANDIDATE_MARGIN * expected.overlap_area))
    elif old_area == 0.0:
        nodes = np.flatnonzero(gap + state.holder_z < 0.0)
        active = nodes
    else:
        # The scar's shape changes less than the height at which it is met: guess the contact by its area.
        nodes = _closest(gap, areas, _CANDIDATE_MARGIN * state.overlap_area)
        active = _closest(gap, areas, old_area)
    height = state.holder_z
    guess = state.traction if expected is None else expected.traction
    iterations = 0
    for pairings in range(1, _MOST_PAIRINGS + 1):
        if not len(nodes):
            raise _LostContactError("the bodies have lost contact")
        offset = problem.offset(drive, holder_x)
        pairing = pair(problem.surface, problem.secondary, nodes, offset, *_open_depths(problem, state), tilt)
        system = _linearisation(problem, state, pairing, drive, holder_x, cycles, prescribed_height)
        outcome = solve_contact(system, guess[nodes], np.isin(nodes, active), height, holder_x)
        iterations += outcome.iterations
        if outcome.message == LOST_CONTACT:
            raise _LostContactError(LOST_CONTACT)
        if not outcome.converged:
            raise _NotConvergedError(outcome.message)
        guess = np.zeros_like(state.traction)
        guess[nodes] = outcome.traction
        moved = abs(outcome.holder_x - holder_x)
        holder_x, height, tilt = outcome.holder_x, outcome.height, outcome.tilt
        gap = _vertical_gaps(problem, state, drive, holder_x)
        missing = np.setdiff1d(np.flatnonzero(gap + height < 0.0), nodes)
        if moved <= tolerance and not len(missing):
            overlap = float(areas[gap + height < 0.0].sum())
            return _accept(problem, state, pairing, outcome, drive, cycles, overlap, iterations, pairings)
        active = np.flatnonzero(guess[:, 2] > 0.0)
        nodes = np.union1d(active, np.flatnonzero(gap + height < 0.02 * abs(height)))
    raise _NotConvergedError("the pairing of the surfaces did not settle")


def _predicted_holder_position(problem: ContactProblem, state: ContactState, drive: float) -> float:
    """Where the holder will be if the contact goes on sticking or sliding as it did."""
    compliance = problem.holder.compliance_at_contact_mm_per_N
    if (compliance == 0.0 and problem.holder.play_mm == 0.0) or problem.friction == 0.0:
        return state.holder_x
    step = drive - state.drive
    slid_before = abs(state.holder_rate) < 0.5
    if slid_before and step * state.holder_x > 0.0:
        return state.holder_x + state.holder_rate * step
    limit = problem.friction * float(state.primary_force[:, 2].sum()) * compliance + 0.5 * problem.holder.play_mm
    return float(np.clip(state.holder_x + step, -limit, limit))


def _linearisation(
    problem: ContactProblem,
    state: ContactState,
    pairing: Pairing,
    drive: float,
    holder_x: float,
    cycles: float,
    prescribed_height: float | None,
) -> Linearisation:
    holder = problem.holder
    if prescribed_height is None and holder.approach_mm is not None:
        prescribed_height = -holder.approach_mm
    wear_gap = None
    if cycles > 0.0 and problem.wear.implicit and not problem.wear.none:
        wear_gap = (cycles * open_share(problem.layers)) * worn_gap_operator(
            pairing, problem.secondary.patch.node_areas(), *problem.wear.split(problem.primary_is_upper)
        )
    compliance, old_displacement = paired_compliance(
        pairing,
        _old_transfer(problem, state, pairing),
        problem.primary,
        problem.secondary,
        (state.primary_force, state.secondary_force),
        problem.layer_mm_per_MPa,
    )
    old_displacement = old_displacement + problem.layer_mm_per_MPa * state.traction[pairing.nodes]
    return Linearisation(
        pairing=pairing,
        compliance=compliance,
        old_displacement=old_displacement,
        friction=problem.friction,
        wear_gap=wear_gap,
        wear_work_per_load_and_slip=problem.wear.work_per_load_and_slip(problem.friction),
        paired_holder_x=holder_x,
        old_holder_x=state.holder_x,
        old_height=state.holder_z,
        drive_step=drive - state.drive,
        old_tilt=state.holder_tilt,
        lever=_levers(problem, drive, holder_x)[pairing.nodes],
        holder=holder,
        pressed_height=state.pressed_z,
        prescribed_height=prescribed_height,
        old_place_in_play=holder.place_in_play_mm(
            state.holder_x, state.holder_tilt, float(state.primary_force[:, 0].sum())
        ),
        layers=_layers(problem, state, pairing) if problem.layers else None,
    )


def _layers(problem: ContactProblem, state: ContactState, pairing: Pairing) -> LayersAtNodes:
    own = state.wear.primary_depth.ravel()[pairing.nodes]
    other = pairing.secondary @ state.wear.secondary_depth.ravel() / pairing.areas
    return layers_at_nodes(problem.layers, own + other, state.traction[pairing.nodes])


def _old_transfer(problem: ContactProblem, state: ContactState, pairing: Pairing) -> csr_matrix:
    """Where the secondary's displacement before the increment is taken, as a transfer (k, n).

    Material velocities make the slip, so it is taken where a node will be, except at nodes that stuck: the place they
    face does not change, but the rigid offset of the undeformed bodies does, and the strain along it would make them
    creep a little in every cycle.
    """
    traction = state.traction[pairing.nodes]
    normal = np.einsum("ij,ij->i", traction, pairing.frames[:, 0, :])
    tangential = np.linalg.norm(traction - normal[:, None] * pairing.frames[:, 0, :], axis=1)
    stuck = np.flatnonzero(tangential < (1.0 - _STICK_MARGIN) * problem.friction * normal)
    if not len(stuck):
        return pairing.secondary
    before = pair(
        problem.surface,
        problem.secondary,
        pairing.nodes[stuck],
        problem.offset(state.drive, state.holder_x),
        state.wear.primary_depth,
        state.wear.secondary_depth,
    ).secondary
    rows = np.ones(len(pairing.nodes))
    rows[stuck] = 0.0
    places = csr_matrix((np.ones(len(stuck)), (stuck, np.arange(len(stuck)))), shape=(len(rows), len(stuck)))
    return csr_matrix(diags(rows) @ pairing.secondary + places @ before)


def _accept(
    problem: ContactProblem,
    state: ContactState,
    pairing: Pairing,
    outcome: NewtonOutcome,
    drive: float,
    cycles: float,
    overlap_area: float,
    iterations: int,
    pairings: int,
) -> tuple[ContactState, IncrementReport]:
    pressed = outcome.traction[:, 2] > 0.0
    if np.any(pressed & ~pairing.inside):
        raise PatchLeftError(
            f"the contact has left the finely meshed patch of the {'lower' if problem.primary_is_upper else 'upper'} "
            f"body at a displacement of {1e3 * drive:.2f} um; give a larger patch (scar_half_width_um)"
        )
    _require_inside_primary(problem, pairing.nodes[pressed], drive)
    traction = np.zeros_like(state.traction)
    traction[pairing.nodes] = outcome.traction
    slid = state.primary_slid.copy()
    slid[pairing.nodes] += outcome.slip_length
    energy = outcome.friction_energy
    wear = deposited(
        state.wear,
        pairing,
        energy,
        outcome.wear_work,
        cycles,
        problem.wear.split(problem.primary_is_upper),
        problem.secondary.patch,
    )
    new = replace(
        state,
        wear=wear,
        drive=drive,
        holder_x=outcome.holder_x,
        holder_z=outcome.height,
        holder_tilt=outcome.tilt,
        holder_rate=(outcome.holder_x - state.holder_x) / (drive - state.drive) if drive != state.drive else 1.0,
        overlap_area=overlap_area,
        traction=traction,
        primary_force=pairing.primary.T @ outcome.traction,
        secondary_force=pairing.secondary.T @ outcome.traction,
        primary_slid=slid,
        secondary_slid=state.secondary_slid
        + (pairing.secondary.T @ outcome.slip_length) / problem.secondary.patch.node_areas(),
    )
    return new, _report(problem, pairing, outcome, energy, iterations, pairings)


def _require_inside_primary(problem: ContactProblem, nodes: IntArray, drive: float) -> None:
    if problem.primary.patch.edge_nodes()[nodes].any():
        raise PatchLeftError(
            f"the contact has reached the edge of the finely meshed patch of the "
            f"{'upper' if problem.primary_is_upper else 'lower'} body at a displacement of {1e3 * drive:.2f} um; "
            "give a larger patch (scar_half_width_um)"
        )


def _report(
    problem: ContactProblem, pairing: Pairing, outcome: NewtonOutcome, energy: Array, iterations: int, pairings: int
) -> IncrementReport:
    force = pairing.areas @ outcome.traction
    pressed = outcome.traction[:, 2] > 0.0
    normals = pairing.frames[:, 0, :]
    pressure = np.einsum("ij,ij->i", outcome.traction, normals) * normals[:, 2]
    position = problem.primary.node_positions[pairing.nodes[pressed]]
    half = 0.5 * np.ptp(position, axis=0) if len(position) else np.zeros(2)
    return IncrementReport(
        tangential_force=float(force[0]),
        normal_force=float(force[2]),
        friction_work=float(pairing.areas @ energy),
        iterations=iterations,
        pairings=pairings,
        active=int(pressed.sum()),
        sticking=outcome.sticking,
        contact_area=float(pairing.areas[pressed].sum()),
        max_pressure=float(pressure.max()),
        half_width_x=float(half[0]),
        half_width_y=float(half[1]),
        force_error=outcome.force_error,
        penetration=outcome.penetration,
        complementarity=outcome.complementarity,
        slip_direction_error=outcome.slip_direction_error,
        elastic_slip=outcome.elastic_slip,
    )
