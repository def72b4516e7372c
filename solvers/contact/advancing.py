"""Motion of the lower body in increments as short as Newton's method needs them. Each pairs the surfaces first.

An increment pairs the surfaces at a predicted position of the holder and solves the contact conditions; it repeats both
until the holder stays where the surfaces were paired. Drive is the displacement of the lower body along x. The core is
the part of the contact that has stuck ever since the bodies were pressed together.
"""

from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from geometry.arrays import Array, IntArray
from solvers.contact.acceptance import accepted
from solvers.contact.mirrored import images_across, solved_on_one_side
from solvers.contact.problem import (
    ContactProblem,
    faced,
    law_at,
    levers,
    linearised,
    paired_before,
    sliding_force,
    vertical_gaps,
    with_prints,
)
from solvers.contact_conditions import LOST_CONTACT, ContactGuess, ContactOutcome, Linearisation
from solvers.contact_state import ContactState, FirstGuess, IncrementReport
from solvers.drive import LEAST_LOAD
from solvers.elasticity.compliance import displacement_at
from solvers.errors import NotConvergedError, PatchLeftError, SolverError

_PRINTED = 1e-4  # Prints have settled when they change by no more than this share of the holder's height.
_FOLLOWED = 6  # Pairings in which friction follows the speed of sliding.

_LEAST, _FEW = 12, 128  # Nodes searched at the least, and how many are put in order at first to find them.
_BRACKET, _HEIGHT_TOLERANCE = 1.25, 1e-8  # Of heights at which surfaces that yield bear the load.


def press(problem: ContactProblem, state: ContactState) -> tuple[ContactState, IncrementReport]:
    """Apply the normal load, or the holder's approach, without friction and without motion. Returns the state and its
    report.

    Nodes that touch become the core. A holder's height other than 0 at which bodies overlap is a first guess. Raises
    SolverError when no contact is found under the load.
    """
    frictionless = replace(problem, friction=0.0)
    if problem.holder.approach_mm is not None:
        lowered = replace(state, holder_z=-problem.holder.approach_mm, pressed_z=-problem.holder.approach_mm)
        held, report = solve_increment(frictionless, lowered, state.drive, 0.0)
        return _stuck(held), report
    height, gaps = state.holder_z, vertical_gaps(problem, state, state.drive, state.holder_x)
    if height == 0.0 or not (gaps + height < 0.0).any():
        height = min(_height_under_load(frictionless, state), _height_that_bears(problem, state))
    start = replace(state, holder_z=height, pressed_z=height)
    rigid = replace(frictionless, holder=replace(problem.holder, normal_stiffness_N_per_mm=0.0))
    try:
        pressed, report = solve_increment(rigid, start, state.drive, 0.0)
    except IncrementFailedError:
        if problem.limit is None:
            raise
        pressed, report = _lowered_to_load(rigid, start)
    return _stuck(replace(pressed, pressed_z=pressed.holder_z)), report


def _lowered_to_load(problem: ContactProblem, state: ContactState) -> tuple[ContactState, IncrementReport]:
    """Press by seeking the holder's height at which the load is borne.

    Needed where everything that touches yields: a little more load then moves the bodies far and presses many more
    nodes, but a little more height does not.
    """
    load = problem.holder.under(state.load_share).normal_load_N

    def held(height: float) -> tuple[ContactState, IncrementReport]:
        at = replace(state, holder_z=height, pressed_z=height)
        return solve_increment(problem, at, state.drive, 0.0, prescribed_height=height)

    def excess(height: float) -> float:
        try:
            return float(held(height)[0].primary_force[:, 2].sum()) - load
        except LostContactError:
            return -load
        except PatchLeftError:
            return load

    low = high = state.holder_z
    while excess(low) < 0.0:
        low *= _BRACKET
    while excess(high) > 0.0:
        high /= _BRACKET
    return held(brentq(excess, low, high, xtol=_HEIGHT_TOLERANCE * abs(low)))


def _stuck(state: ContactState) -> ContactState:
    """The state with all touching nodes as the core."""
    return replace(state, core=state.traction[:, 2] > 0.0, pressed_ahead=state.drive - state.holder_x)


def _height_that_bears(problem: ContactProblem, state: ContactState) -> float:
    """First guess of the holder's height (<= 0): where yielding surfaces overlap on an area that bears the load at
    their limit.
    """
    if problem.limit is None:
        return 0.0
    load = problem.holder.under(state.load_share).normal_load_N
    gap, areas = vertical_gaps(problem, state, state.drive, state.holder_x), problem.surface.areas
    # Of the area that bears the load with surfaces that yield all over.
    return -float(gap[_closest(gap, areas, 1.2 * load / float(problem.limit.limit_MPa(load)))].max(initial=0.0))


def _height_under_load(problem: ContactProblem, state: ContactState) -> float:
    """First guess of the holder's height: the approach is enlarged until a Newton solution at this height carries the
    load.
    """
    load = problem.holder.under(state.load_share).normal_load_N
    elastic = float(np.median(problem.primary.folded.diagonal())) * load
    # Bodies with a depth from the outset touch below the height at which unworn ones would.
    touch = max(float(vertical_gaps(problem, state, state.drive, state.holder_x).min()), 0.0)
    approach = 0.1 * elastic
    least = 1e-2 * approach
    for _ in range(60):
        height = -touch - approach
        guess = replace(state, holder_z=height, pressed_z=height)
        try:
            pressed, _report = solve_increment(problem, guess, state.drive, 0.0, prescribed_height=height)
        except LostContactError:
            # One node alone touches before its whole support, on average, does.
            approach *= 1.6
            continue
        except (IncrementFailedError, PatchLeftError) as failure:
            # By a node's own compliance a fine mesh is soft: the first guess may press it beyond its patch.
            if isinstance(failure, PatchLeftError) and approach < least:
                raise
            approach *= 0.5
            continue
        force = float(pressed.primary_force[:, 2].sum())
        if force > 0.3 * load:
            return -touch - approach * float((load / force) ** (2.0 / 3.0))
        approach *= 1.6
    raise SolverError("the bodies could not be pressed together: no contact found under the normal load")


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
        nodes = _either(len(gap), active, _closest(gap, areas, 1.15 * like.overlap_area))
    height, iterations, before, slip_share = state.holder_z, 0, paired_before(problem, state), state.slip_share
    images = images_across(problem, state)
    for pairings in range(1, 13):
        if not len(nodes):
            raise LostContactError("the bodies have lost contact")
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
            return accepted(problem, state, system, outcome, drive, cycles, overlap, slip_share, iterations, pairings)
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


def _closest(gap: Array, areas: Array, area: float) -> IntArray:
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


def parted(problem: ContactProblem, state: ContactState, drive: float) -> tuple[ContactState, IncrementReport]:
    """The state at `drive` (mm) of bodies that do not touch, without forces and with the holder at rest within its free
    play, and a report without forces.
    """
    stop = 0.5 * problem.holder.play_mm
    holder_x = float(np.clip(state.holder_x, -stop, stop))
    none = np.zeros_like(state.traction)
    apart = replace(
        state,
        drive=drive,
        holder_x=holder_x,
        holder_tilt=state.holder_tilt + problem.holder.tilt_per_motion_rad_per_mm * (holder_x - state.holder_x),
        holder_rate=0.0,
        overlap_area=0.0,
        traction=none,
        primary_force=none,
        secondary_force=np.zeros_like(state.secondary_force),
        core=np.zeros_like(state.core),
        slip_share=np.zeros_like(state.slip_share),
    )
    return apart, IncrementReport(drive)


def opened(
    problem: ContactProblem, state: ContactState, drive: float, cycles: float
) -> tuple[ContactState, IncrementReport]:
    """The state at `drive` (mm) of bodies whose load has been removed in an increment, and its report; cycles: number
    of times that its wear counts.

    The bodies are left just touching. As the load goes, they slide by the strain and the rig's motion that are
    released, with half of the work that the pressures before would do along it, as in any increment.
    """
    apart, report = parted(problem, state, drive)
    height = -float(vertical_gaps(problem, apart, drive, apart.holder_x).min())
    before = paired_before(problem, state)
    if not len(before.nodes):
        return replace(apart, holder_z=height), report
    pairing = faced(problem, state, before.nodes, drive, apart.holder_x, apart.holder_tilt)
    known = state.slip_share, state.traction
    system = linearised(problem, state, before, pairing, drive, apart.holder_x, height, *known)
    place = apart.holder_x, height, apart.holder_tilt
    return accepted(
        problem,
        state,
        system,
        ContactOutcome.nothing_pressed(len(before.nodes), *place),
        drive,
        cycles,
        0.0,
        0.0 * state.slip_share,
        0,
        0,
    )


def advance(
    problem: ContactProblem,
    state: ContactState,
    drive: float,
    cycles: float,
    guess: FirstGuess | None = None,
    load_share: float | None = None,
    bulk: Array | None = None,
) -> tuple[ContactState, list[IncrementReport]]:
    """Move the lower body to `drive` (mm); each bit of slip wears as if repeated `cycles` times (0: no wear). Returns
    the state and the reports of the increments made: the increment is cut into shorter ones where Newton's method does
    not converge.

    guess: the contact of an earlier cycle at this drive; None: the previous state. load_share: normal load at the end
    over the test's; None: unchanged. Below 1 % of it, and under a held approach, the bodies may part, and meet again.
    bulk: `ContactState.bulk` at the end; None: unchanged. Raises NotConvergedError when even increments of 1/256 fail.
    """
    reports: list[IncrementReport] = []
    pieces = 1
    done = reached = 0.0
    start, current = state.drive, state
    loaded, more = state.load_share, 0.0 if load_share is None else load_share - state.load_share
    stretched, strain = state.bulk, np.zeros_like(state.bulk) if bulk is None else bulk - state.bulk
    while done < 1.0 - 1e-12:
        share = min(1.0 / pieces, 1.0 - done)
        place, load = start + (done + share) * (drive - start), loaded + (done + share) * more
        bulk, step = stretched + (done + share) * strain, (done + share - reached) * strain
        if load < LEAST_LOAD:
            if more > 0.0 and done + share < 1.0 - 1e-12 and not current.traction.any():
                # Bodies that meet stick from where they met: the next piece begins there.
                done += share
                continue
            current, report = opened(problem, replace(current, bulk=bulk, bulk_step=step), place, cycles)
            current = replace(current, load_share=load)
            done = reached = done + share
            reports.append(report)
            continue
        current = replace(current, load_share=load, bulk=bulk, bulk_step=step)
        if more != 0.0 and not current.traction.any():
            current = replace(current, holder_z=_height_under_load(replace(problem, friction=0.0), current))
        try:
            # An increment that had to be cut was led astray by its guess, too.
            expected = guess if pieces == 1 else None
            current, report = solve_increment(problem, current, place, cycles, expected=expected)
        except IncrementFailedError as failure:
            pieces *= 2
            if pieces > 256:
                if _may_part(problem, current, drive, failure):
                    current, report = _parted_or_met(problem, current, drive)
                    return current, [*reports, report]
                stuck_um = 1e3 * (start + done * (drive - start))
                raise NotConvergedError(
                    f"the contact did not converge at a displacement of {stuck_um:.3f} um, even in steps of "
                    f"1/{pieces // 2} increment: {failure}"
                ) from None
            continue
        done = reached = done + share
        reports.append(report)
    return current, reports


def _may_part(problem: ContactProblem, state: ContactState, drive: float, failure: IncrementFailedError) -> bool:
    """True if bodies under a held approach have lost contact on the way to `drive`, or overlap, undeformed, by hardly
    anything.

    Always False where a load presses them.
    """
    approach = problem.holder.approach_mm
    if approach is None or isinstance(failure, LostContactError):
        return approach is not None
    gap = vertical_gaps(problem, state, drive, state.holder_x) + state.holder_z
    # Of a held approach.
    return float(gap.min()) > -0.01 * approach


def _parted_or_met(problem: ContactProblem, state: ContactState, drive: float) -> tuple[ContactState, IncrementReport]:
    """The state and report at `drive` of bodies that have lost contact on the way there: touching if they overlap, else
    apart.
    """
    apart, report = parted(problem, state, drive)
    try:
        return solve_increment(problem, apart, drive, 0.0)
    except IncrementFailedError:
        return apart, report
