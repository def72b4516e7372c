"""Pressing two bodies together under the normal load."""

from dataclasses import replace

import numpy as np

from solvers.contact.gaps import vertical_gaps
from solvers.contact.increment import IncrementFailedError, LostContactError, solve_increment
from solvers.contact.problem import ContactProblem
from solvers.contact_state import ContactState, IncrementReport
from solvers.errors import SolverError


def press(problem: ContactProblem, state: ContactState) -> tuple[ContactState, IncrementReport]:
    """Apply the normal load without friction and without motion."""
    frictionless = replace(problem, friction=0.0)
    if problem.holder.approach_mm is not None:
        lowered = replace(state, holder_z=-problem.holder.approach_mm, pressed_z=-problem.holder.approach_mm)
        held, report = solve_increment(frictionless, lowered, state.drive, 0.0)
        return _stuck(held), report
    height = _height_under_load(frictionless, state)
    start = replace(state, holder_z=height, pressed_z=height)
    rigid = replace(frictionless, holder=replace(problem.holder, normal_stiffness_N_per_mm=0.0))
    pressed, report = solve_increment(rigid, start, state.drive, 0.0)
    return _stuck(replace(pressed, pressed_z=pressed.holder_z)), report


def _stuck(state: ContactState) -> ContactState:
    """The state of bodies that stick to each other from here on wherever they touch."""
    return replace(state, core=state.traction[:, 2] > 0.0, pressed_ahead=state.drive - state.holder_x)


def _height_under_load(problem: ContactProblem, state: ContactState) -> float:
    """Height of the holder at which rigid interpenetration would carry about the load, as a first guess.

    Doubles the approach until a first Newton solution under prescribed height carries the load.
    """
    elastic = float(np.median(problem.primary.folded.diagonal())) * problem.holder.normal_load_N
    # Bodies with a depth from the outset touch below the height at which unworn ones would.
    touch = max(float(vertical_gaps(problem, state, state.drive, state.holder_x).min()), 0.0)
    approach = 0.1 * elastic
    for _ in range(60):
        height = -touch - approach
        guess = replace(state, holder_z=height, pressed_z=height)
        try:
            pressed, _report = solve_increment(problem, guess, state.drive, 0.0, prescribed_height=height)
        except LostContactError:
            # One node alone touches before its whole support, on average, does.
            approach *= 1.6
            continue
        except IncrementFailedError:
            approach *= 0.5
            continue
        force = float(pressed.primary_force[:, 2].sum())
        if force > 0.3 * problem.holder.normal_load_N:
            return -touch - approach * float((problem.holder.normal_load_N / force) ** (2.0 / 3.0))
        approach *= 1.6
    raise SolverError("the bodies could not be pressed together: no contact found under the normal load")
