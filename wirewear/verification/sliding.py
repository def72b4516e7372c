"""The sliding wires that rig loop, book-keeping and limits share: proportions like the steel wires' test."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from solvers import (
    ContactProblem,
    ContactState,
    CycleTrace,
    Holder,
    WearRates,
    closed_trace,
    first_quarter,
    jump_cycles,
    press,
    run_cycle,
    symmetry_of,
    unloaded_state,
)
from wirewear.verification.wires import LOAD_N, CONTACT_RADIUS_mm, condensed, crossed, wire_geometry

Array = NDArray[np.float64]

FRICTION = 0.6
#: Sliding bends the rig by half a contact radius; the contact slides by about two to each side.
RIG_STIFFNESS_N_per_mm = FRICTION * LOAD_N / (0.5 * CONTACT_RADIUS_mm)
AMPLITUDE_mm = 2.4 * CONTACT_RADIUS_mm
INCREMENTS = 40


def sliding_wires(
    resolution: float,
    *,
    friction: float = FRICTION,
    rig_compliance_mm_per_N: float = 1.0 / RIG_STIFFNESS_N_per_mm,
    wear: WearRates | None = None,
    primary_is_upper: bool = True,
) -> ContactProblem:
    """Equal wires crossed at right angles behind the rig's spring."""
    body = condensed(wire_geometry(resolution, long_patch=True))
    holder = Holder(LOAD_N, rig_compliance_mm_per_N)
    return crossed(body, body, holder, friction=friction, wear=wear, primary_is_upper=primary_is_upper)


def at_end_of_stroke(problem: ContactProblem, amplitude_mm: float = AMPLITUDE_mm) -> ContactState:
    """Pressed together and moved from mid-stroke to `amplitude_mm`, which may be negative."""
    pressed, _ = press(problem, unloaded_state(problem))
    return first_quarter(problem, pressed, amplitude_mm, INCREMENTS)


def whole_loop(problem: ContactProblem, amplitude_mm: float = AMPLITUDE_mm) -> CycleTrace:
    """The first full cycle from the end of the stroke at `amplitude_mm`, without wear."""
    start = at_end_of_stroke(problem, amplitude_mm)
    return run_cycle(problem, start, abs(amplitude_mm), INCREMENTS, 0.0)[1]


def jumped(problem: ContactProblem, start: ContactState, cycles: float) -> ContactState:
    """The state after so many cycles in one jump from the end of the stroke."""
    symmetry = symmetry_of(problem)
    begin, trace = closed_trace(problem, start, AMPLITUDE_mm, INCREMENTS, symmetry)
    return jump_cycles(lambda *_: problem, begin, trace, symmetry, 1.0, cycles).state


def half_width_at_zero_force(drive_mm: Array, force_N: Array) -> float:
    """Half the distance between the loop's two crossings of zero force, in mm."""
    before = np.roll(force_N, 1)
    crossing = np.flatnonzero((force_N > 0.0) != (before > 0.0))
    share = before[crossing] / (before[crossing] - force_N[crossing])
    previous = np.roll(drive_mm, 1)[crossing]
    return float(0.5 * np.ptp(previous + share * (drive_mm[crossing] - previous)))
