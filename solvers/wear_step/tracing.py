"""The cycle along which surfaces wear, traced with the wear frozen until it closes."""

import numpy as np

from solvers.contact import ContactProblem
from solvers.contact_state import ContactState
from solvers.fretting import CycleTrace, Watch, anew, sticks_throughout, traced_cycle
from solvers.guide import Guide
from solvers.wear_step.symmetry import Symmetry, mirrored, with_images

# A cycle is closed when friction at its end differs from that at its start by this share of it, summed over the nodes.
_CLOSURE = 0.01
_MOST_CYCLES = 4


def closed_trace(
    problem: ContactProblem,
    state: ContactState,
    amplitude_mm: float,
    increments: int,
    symmetry: Symmetry,
    watch: Watch | None = None,
    guide: Guide | None = None,
) -> tuple[ContactState, CycleTrace]:
    """The state where a closed cycle starts, at either end of the stroke, and the cycle; its first half where the
    symmetry maps that onto the second.

    Sliding wipes out what a state remembers of surfaces before they wore; where the contact sticks in its middle, it is
    moved anew from mid-stroke.
    """
    mirror, start = symmetry.half_cycle, state
    guide = None if guide is None else with_images(guide, mirror)
    for cycle in range(_MOST_CYCLES):
        end, trace = traced_cycle(
            problem, start, amplitude_mm, increments, half=mirror is not None, watch=watch, guide=guide
        )
        if cycle == 0 and sticks_throughout(start, end):
            start, guide = anew(problem, start, amplitude_mm, increments, watch), None
            continue
        image = end if mirror is None else mirrored(end, mirror)
        if cycle == _MOST_CYCLES - 1 or _friction_difference(problem, start, image) <= _CLOSURE:
            break
        start, guide = end, with_images(trace.guide, mirror)
    return start, trace


def _friction_difference(problem: ContactProblem, first: ContactState, second: ContactState) -> float:
    areas = problem.surface.areas
    total = float(areas @ np.abs(first.traction[:, 0]))
    return float(areas @ np.abs(first.traction[:, 0] - second.traction[:, 0])) / max(total, 1e-300)
