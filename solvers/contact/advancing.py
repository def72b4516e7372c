"""Motion of the lower body, in increments as short as Newton's method needs them."""

from dataclasses import replace

import numpy as np

from solvers.contact.increment import IncrementFailedError, LostContactError, solve_increment
from solvers.contact.linearisation import vertical_gaps
from solvers.contact.problem import ContactProblem
from solvers.contact_state import ContactState, IncrementReport
from solvers.errors import NotConvergedError
from solvers.holder import FirstGuess

_MOST_CUTS = 8

_BARELY = 0.01  # Of a held approach.


def parted(problem: ContactProblem, state: ContactState, drive: float) -> tuple[ContactState, IncrementReport]:
    """The state at `drive` of bodies that do not touch, and the report of it: no force, and the holder at rest."""
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
    )
    return apart, IncrementReport(
        drive=drive,
        tangential_force=0.0,
        normal_force=0.0,
        friction_work=0.0,
        iterations=0,
        pairings=0,
        active=0,
        sticking=0,
        contact_area=0.0,
        max_pressure=0.0,
        inner_pressure=0.0,
        half_width_x=0.0,
        half_width_y=0.0,
        force_error=0.0,
        penetration=0.0,
        complementarity=0.0,
        slip_direction_error=0.0,
        elastic_slip=0.0,
    )


def advance(
    problem: ContactProblem, state: ContactState, drive: float, cycles: float, guess: FirstGuess | None = None
) -> tuple[ContactState, list[IncrementReport]]:
    """Move the lower body to `drive`, each bit of slip wearing as if repeated `cycles` times (0: wear frozen).

    guess: what a cycle before came to at this drive, a better first guess than the last increment.
    Cuts the increment where Newton's method does not converge; NotConvergedError when even tiny ones fail. Under a held
    approach bodies may part, and meet again.
    """
    reports: list[IncrementReport] = []
    pieces = 1
    done = 0.0
    start, current = state.drive, state
    while done < 1.0 - 1e-12:
        share = min(1.0 / pieces, 1.0 - done)
        try:
            # An increment that had to be cut was led astray by its guess, too.
            expected = guess if pieces == 1 else None
            current, report = solve_increment(
                problem, current, start + (done + share) * (drive - start), cycles, expected=expected
            )
        except IncrementFailedError as failure:
            pieces *= 2
            if pieces > 2**_MOST_CUTS:
                if _may_part(problem, current, drive, failure):
                    current, report = _parted_or_met(problem, current, drive)
                    return current, [*reports, report]
                place = 1e3 * (start + done * (drive - start))
                raise NotConvergedError(
                    f"the contact did not converge at a displacement of {place:.3f} um, even in steps of "
                    f"1/{pieces // 2} increment: {failure}"
                ) from None
            continue
        done += share
        reports.append(report)
    return current, reports


def _may_part(problem: ContactProblem, state: ContactState, drive: float, failure: IncrementFailedError) -> bool:
    """Whether bodies under a held approach have opened on the way to `drive`, or overlap undeformed by next to nothing;
    never where a load presses them.
    """
    approach = problem.holder.approach_mm
    if approach is None or isinstance(failure, LostContactError):
        return approach is not None
    gap = vertical_gaps(problem, state, drive, state.holder_x) + state.holder_z
    return float(gap.min()) > -_BARELY * approach


def _parted_or_met(problem: ContactProblem, state: ContactState, drive: float) -> tuple[ContactState, IncrementReport]:
    """Bodies at `drive` that have opened on the way there: touching where they overlap now, or apart."""
    apart, report = parted(problem, state, drive)
    try:
        return solve_increment(problem, apart, drive, 0.0)
    except IncrementFailedError:
        return apart, report
