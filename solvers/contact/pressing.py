"""Two bodies pressed together, under the normal load or to the holder's approach, without motion."""

from dataclasses import replace

import numpy as np
import scipy

from solvers.contact.increment import IncrementFailedError, LostContactError, closest, solve_increment
from solvers.contact.problem import ContactProblem, vertical_gaps
from solvers.contact_state import ContactState, FirstGuess, IncrementReport
from solvers.errors import PatchLeftError, SolverError

_BRACKET, _HEIGHT_TOLERANCE = 1.25, 1e-8  # Of heights at which surfaces that yield carry the load.


def press(
    problem: ContactProblem, state: ContactState, expected: FirstGuess | None = None
) -> tuple[ContactState, IncrementReport]:
    """Apply the normal load, or the holder's approach, without friction and without motion. Returns the state and its
    report.

    Nodes that touch become the core. A holder's height other than 0 at which bodies overlap is a first guess; expected:
    what goes with it, None: nothing. Raises SolverError when no contact is found under the load.
    """
    frictionless = replace(problem, friction=0.0)
    if problem.holder.approach_mm is not None:
        lowered = replace(state, holder_z=-problem.holder.approach_mm, pressed_z=-problem.holder.approach_mm)
        held, report = solve_increment(frictionless, lowered, state.drive, 0.0, expected=expected)
        return _stuck(held), report
    height, gaps = state.holder_z, vertical_gaps(problem, state, state.drive, state.holder_x)
    if height == 0.0 or not (gaps + height < 0.0).any():
        height, expected = min(height_under_load(frictionless, state), _height_that_bears(problem, state)), None
    start = replace(state, holder_z=height, pressed_z=height)
    rigid = replace(frictionless, holder=replace(problem.holder, normal_stiffness_N_per_mm=0.0))
    try:
        pressed, report = solve_increment(rigid, start, state.drive, 0.0, expected=expected)
    except IncrementFailedError:
        if problem.limit is None:
            raise
        pressed, report = _lowered_to_load(rigid, start)
    return _stuck(replace(pressed, pressed_z=pressed.holder_z)), report


def _lowered_to_load(problem: ContactProblem, state: ContactState) -> tuple[ContactState, IncrementReport]:
    """Press by seeking the holder's height at which it carries the load.

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
    return held(scipy.optimize.brentq(excess, low, high, xtol=_HEIGHT_TOLERANCE * abs(low)))


def _stuck(state: ContactState) -> ContactState:
    """The state with all touching nodes as the core."""
    return replace(state, core=state.traction[:, 2] > 0.0, pressed_ahead=state.drive - state.holder_x)


def _height_that_bears(problem: ContactProblem, state: ContactState) -> float:
    """First guess of the holder's height (<= 0): where yielding surfaces overlap on an area that carries the load at
    their limit.
    """
    if problem.limit is None:
        return 0.0
    load = problem.holder.under(state.load_share).normal_load_N
    gap, areas = vertical_gaps(problem, state, state.drive, state.holder_x), problem.surface.areas
    # Of the area that carries the load with surfaces that yield all over.
    return -float(gap[closest(gap, areas, 1.2 * load / float(problem.limit.limit_MPa(load)))].max(initial=0.0))


def height_under_load(problem: ContactProblem, state: ContactState) -> float:
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
