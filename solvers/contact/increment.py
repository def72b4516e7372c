"""One increment: the lower body moves to a drive, and the contact conditions are solved there.

An increment pairs the surfaces at a predicted position of the holder and solves the contact conditions; it repeats both
until the holder stays where the surfaces were paired. Drive is the displacement of the lower body along x. The core is
the part of the contact that has stuck ever since the bodies were pressed together.
"""

from dataclasses import replace

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.contact.acceptance import accepted
from solvers.contact.linearising import law_at, linearised, paired_before, sliding_force
from solvers.contact.mirrored import images_across, solved_on_one_side
from solvers.contact.problem import ContactProblem, faced, levers, vertical_gaps, with_prints
from solvers.contact_conditions import LOST_CONTACT, ContactGuess, ContactOutcome, Linearisation
from solvers.contact_state import ContactState, FirstGuess, IncrementReport
from solvers.elasticity.compliance import displacement_at
from solvers.elasticity.pairing import Pairing

_PRINTED = 1e-4  # Prints have settled when they change by no more than this share of the holder's height.

_FOLLOWED = 6  # Pairings in which friction follows the speed of sliding.

_LEAST, _FEW = 12, 128  # Nodes searched at the least, and how many are put in order at first to find them.


class IncrementFailedError(Exception):
    """No solution was found for one increment; the message says how it failed."""


class LostContactError(IncrementFailedError):
    """No node is in contact."""


def solve_increment(
    problem: ContactProblem,
    state: ContactState,
    drive: float,
    cycles: float,
    prescribed_height: float | None = None,
    expected: FirstGuess | None = None,
) -> tuple[ContactState, IncrementReport]:
    """Move the lower body to `drive` (mm) in one increment, pairing the surfaces again until the holder stays where
    assumed. Returns the new state and its report.

    cycles: number of times that the slip counts for wear. prescribed_height: in mm, at which the holder is held instead
    of loaded; None: loaded. expected: a better first guess than the previous state. Raises IncrementFailedError if no
    solution was found, LostContactError where nothing touches, and PatchLeftError if the contact has reached the edge
    of either patch.
    """
    # The pairing is renewed when the holder has moved by more: the gap's error is of second order in that distance.
    tolerance, areas, begins = 0.01 * problem.smallest_element, problem.surface.areas, state
    holder_x = _predicted_holder_position(problem, state, drive) if expected is None else expected.holder_x
    tilt = state.holder_tilt + problem.holder.tilt_per_motion_rad_per_mm * (holder_x - state.holder_x)
    gap = vertical_gaps(problem, state, drive, holder_x)
    like = state if expected is None else expected
    guess = like.traction
    active = np.flatnonzero(guess[:, 2] > 0.0)
    if expected is None and not len(active):
        nodes = active = np.flatnonzero(gap + state.holder_z < 0.0)
    else:
        # The scar's shape changes less than the height at which it is met: guess the overlap by its area.
        nodes = _either(len(gap), active, closest(gap, areas, 1.15 * like.overlap_area))
    height, iterations, slip_share = state.holder_z, 0, state.slip_share
    before: Pairing | None = None
    loaded = np.flatnonzero(state.traction[:, 2] > 0.0)
    images = images_across(problem, state)
    for pairings in range(1, 13):
        if not len(nodes):
            raise LostContactError("the bodies have lost contact")
        # Around a core that does not tilt, surfaces stay paired.
        if state.core.any() and tilt == begins.holder_tilt:
            nodes = _either(len(gap), nodes, loaded)
        elif before is None:
            before = paired_before(problem, begins)
        nodes = nodes if images is None else _either(len(gap), nodes, images[nodes])
        pairing = faced(problem, state, nodes, drive, holder_x, tilt)
        system = linearised(problem, state, before, pairing, drive, holder_x, prescribed_height, slip_share, guess)
        outcome = _solved(problem, system, guess, active, (height, holder_x), images)
        iterations += outcome.iterations
        guess = np.zeros_like(state.traction)
        guess[nodes] = outcome.traction
        moved = abs(outcome.holder_x - holder_x)
        slip_share = _slip_share(state, nodes, outcome, drive)
        # Friction that falls with the speed may have no equilibrium: if it does not settle, it stays as it was last.
        follows = problem.friction_law.timed and pairings < _FOLLOWED
        if follows and system.friction.differs(law_at(problem, state, pairing, slip_share, drive, guess)):
            moved = np.inf
        holder_x, height, tilt = outcome.holder_x, outcome.height, outcome.tilt
        if drive != state.drive and _core_is_lost(state, nodes, outcome):
            # Nothing sticks any more: the surfaces face each other as the bodies have moved.
            state, moved = replace(state, core=np.zeros_like(state.core)), np.inf
        if problem.yields:
            printed = _towards(state, with_prints(problem, begins, _forces(system, outcome)))
            moved = np.inf if _print_change(state, printed) > _PRINTED * abs(height) else moved
            state = replace(state, wear=printed.wear)
        gap = vertical_gaps(problem, state, drive, holder_x)
        overlapping = gap + height < 0.0
        overlapping[nodes] = False
        beside = np.flatnonzero(overlapping)
        if moved <= tolerance and not (len(beside) and _touch(problem, state, system, outcome, drive, beside)):
            overlap = float(areas[gap + height < 0.0].sum())
            return accepted(problem, state, system, outcome, drive, cycles, overlap, slip_share, iterations)
        active = np.flatnonzero(guess[:, 2] > 0.0)
        nodes = _either(len(gap), active, np.flatnonzero(gap + height < 0.02 * abs(height)))
    raise IncrementFailedError("the pairing of the surfaces did not settle")


def _solved(
    problem: ContactProblem,
    system: Linearisation,
    guess: Array,
    active: IntArray,
    holder: tuple[float, float],
    images: IntArray | None,
) -> ContactOutcome:
    """The outcome for a system from guessed tractions (n, 3), nodes `active`, and the holder's height and position.

    images: (n,) mirror image of each node of the primary, if the increment is its own mirror image; halves the
    unknowns. Raises IncrementFailedError if there is no solution, LostContactError where nothing touches.
    """
    nodes, touching = system.pairing.nodes, np.zeros(len(guess), dtype=bool)
    touching[active] = True
    outcome = solved_on_one_side(problem, system, ContactGuess(guess[nodes], touching[nodes], *holder), images)
    if outcome.message == LOST_CONTACT:
        raise LostContactError(LOST_CONTACT)
    if not outcome.converged:
        raise IncrementFailedError(outcome.message)
    return outcome


def _slip_share(state: ContactState, nodes: IntArray, outcome: ContactOutcome, drive: float) -> Array:
    """Slip (n,) of all nodes of the primary over an increment to `drive`, as a share of the drive's signed motion."""
    share = np.zeros_like(state.slip_share)
    if drive != state.drive:
        share[nodes] = outcome.slip_length / (drive - state.drive)
    return share


def _core_is_lost(state: ContactState, nodes: IntArray, outcome: ContactOutcome) -> bool:
    """True if there is a core and none of its nodes sticks any more."""
    sticks = state.core[nodes] & (outcome.traction[:, 2] > 0.0) & ~outcome.sliding
    return bool(state.core.any() and not sticks.any())


def _forces(system: Linearisation, outcome: ContactOutcome) -> tuple[Array, Array]:
    """An outcome's tractions as nodal forces (n, 3) in N on the primary and the secondary."""
    return system.pairing.own.spread(outcome.traction), system.pairing.opposite.spread(outcome.traction)


def _towards(state: ContactState, wanted: ContactState) -> ContactState:
    """The state with its prints moved by 0.7 of the way to the prints of another state."""
    # The deeper a print is, the less pressure makes it: a full step would overshoot.
    primary, secondary = (
        None if now is None or then is None else now + 0.7 * (then - now)
        for now, then in zip(state.wear.prints, wanted.wear.prints, strict=True)
    )
    return replace(state, wear=replace(state.wear, primary_print=primary, secondary_print=secondary))


def _print_change(before: ContactState, after: ContactState) -> float:
    """Largest difference in mm between the prints of two states."""
    pairs = zip(before.wear.prints, after.wear.prints, strict=True)
    return max(float(np.abs(now - then).max()) for then, now in pairs if then is not None and now is not None)


def _touch(
    problem: ContactProblem,
    state: ContactState,
    system: Linearisation,
    outcome: ContactOutcome,
    drive: float,
    nodes: IntArray,
) -> bool:
    """True if any of the nodes outside the pairing, which overlap while undeformed, touches under the outcome's
    tractions.
    """
    paired_x = system.paired_holder_x
    pairing = faced(problem, state, nodes, drive, paired_x, outcome.tilt)
    forces = _forces(system, outcome)
    elastic = displacement_at(pairing, problem.primary, problem.secondary, forces)
    lever = levers(problem, drive, paired_x)[nodes]
    rigid = pairing.gap + outcome.height + lever * outcome.tilt + pairing.gap_rate * (outcome.holder_x - paired_x)
    normals = pairing.frames[:, 0, :]
    return bool((normals[:, 2] * rigid + np.einsum("ij,ij->i", elastic, normals) < 0.0).any())


def _predicted_holder_position(problem: ContactProblem, state: ContactState, drive: float) -> float:
    """Position in mm of the holder at `drive` if the contact goes on sticking or sliding as before."""
    compliance = problem.holder.compliance_at_contact_mm_per_N
    if (compliance == 0.0 and problem.holder.play_mm == 0.0) or problem.friction == 0.0:
        return state.holder_x
    step = drive - state.drive
    slid_before = abs(state.holder_rate) < 0.5
    if slid_before and step * state.holder_x > 0.0:
        return state.holder_x + state.holder_rate * step
    # Turned round it sticks; else it goes on as it did, until friction holds no more.
    step *= 1.0 if slid_before else min(state.holder_rate, 1.0)
    limit = sliding_force(problem, state) * compliance + 0.5 * problem.holder.play_mm
    return float(np.clip(state.holder_x + step, -limit, limit))


def _either(size: int, some: IntArray, others: IntArray) -> IntArray:
    """Indices, increasing, of the nodes below `size` that are among `some` or `others`."""
    among = np.zeros(size, dtype=bool)
    among[some], among[others] = True, True
    return np.flatnonzero(among)


def closest(gap: Array, areas: Array, area: float) -> IntArray:
    """Indices of the nodes with the smallest gaps, the smallest first, whose areas add up to `area`; at least a
    dozen.
    """
    few = _FEW
    while True:
        # Next to all nodes are far from the contact: only the nearest are put in order.
        near = np.arange(len(gap)) if few >= len(gap) else np.flatnonzero(gap <= np.partition(gap, few)[few])
        order = near[np.argsort(gap[near], kind="stable")]
        # The area is often the very sum that is searched for, added in another order: round-off must not decide.
        count = max(int(np.searchsorted(np.cumsum(areas[order]), area * (1.0 - 1e-9))) + 1, _LEAST)
        if count <= len(order) or len(order) == len(gap):
            chosen = order[:count]
            return chosen[np.isfinite(gap[chosen])]
        few *= 4
