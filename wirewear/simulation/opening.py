"""How far a simulated loop opens: its area, and its width by what is known of each increment: which nodes stick."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from solvers import CycleTrace
from wirewear.loops.area import enclosed_area


def dissipated_energy_mJ(trace: CycleTrace) -> float:
    """The area of a closed loop; without friction what is left of it is round-off to either side of 0."""
    return max(enclosed_area(trace.drive, trace.tangential_force), 0.0)


def slip_amplitude_mm(trace: CycleTrace) -> float:
    """Half the width of a closed loop at its mean force, from 0 to half the stroke, mm.

    A branch meets that force before all nodes slide, or else it does so by the slope of a worn scar, which may carry
    more than friction: then it is where all of them come to slide.
    """
    if not any(distance.any() for distance in trace.slid):
        # Where all floats in free play the force that the loop would be judged by is round-off.
        return 0.0
    force, drive = trace.tangential_force, trace.drive
    step = np.abs(np.diff(drive, prepend=drive[-1]))
    mean = float(step @ (force + np.roll(force, 1))) / (2.0 * float(step.sum()))
    falling = trace.phase <= 0.5
    met = [_travel(trace, np.flatnonzero(own), sign, mean) for own, sign in ((falling, -1.0), (~falling, 1.0))]
    return max(0.5 * float(np.ptp(drive)) - 0.5 * sum(met), 0.0)


def _travel(trace: CycleTrace, stroke: NDArray[np.intp], sign: float, mean: float) -> float:
    """Travel along a stroke, the increments of one direction, until it meets the mean force or all nodes slide."""
    points = np.append(stroke[0] - 1, stroke)
    travel = np.abs(trace.drive[points] - trace.drive[points[0]])
    below = sign * (mean - trace.tangential_force[points])
    slides = np.flatnonzero(_sticking(trace)[stroke] == 0)
    met = float(travel[slides[0] + 1]) if slides.size else float(travel[-1])
    passed = np.flatnonzero(below <= 0.0)
    if passed.size and (after := int(passed[0])):
        share = below[after - 1] / (below[after - 1] - below[after])
        return min(met, float(travel[after - 1] + share * (travel[after] - travel[after - 1])))
    return 0.0 if passed.size else met


def _sticking(trace: CycleTrace) -> NDArray[np.int64]:
    """Number of sticking nodes at the end of each increment (n,), which may have been taken in pieces."""
    reports = iter(trace.reports)
    return np.array([next(one.sticking for one in reports if one.drive == state.drive) for state in trace.states])
