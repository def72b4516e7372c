"""Motion of the lower body in increments as short as Newton's method needs them.

Under a load that goes, and under a held approach, bodies part and meet again.
"""

from dataclasses import replace

import numpy as np

from geometry.arrays import Array
from solvers.contact.acceptance import accepted
from solvers.contact.increment import IncrementFailedError, LostContactError, solve_increment
from solvers.contact.linearising import linearised, paired_before
from solvers.contact.pressing import height_under_load
from solvers.contact.problem import ContactProblem, faced, vertical_gaps
from solvers.contact_conditions import ContactOutcome
from solvers.contact_state import ContactState, FirstGuess, IncrementReport
from solvers.drive import LEAST_LOAD
from solvers.errors import NotConvergedError


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
            current = replace(current, holder_z=height_under_load(replace(problem, friction=0.0), current))
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
