"""At which increments of a cycle surfaces wear, and from where to where the bodies slide before and after each.

Where load or bulk stress change within a cycle, many increments follow how the contact sticks and slides; as many
positions would make the equations of a jump many times as large. Those that are kept stand for the work of the others,
too: work between two of them is shared by how near to either it was done along the slip, so that none is lost.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from geometry.arrays import Array, BoolArray, IntArray
from solvers.contact import ContactProblem
from solvers.contact_state import ContactState
from solvers.fretting import CycleTrace
from solvers.wear_path import WornPlaces, slides, spread_over_slip
from solvers.wear_step.symmetry import Mirror, mirrored


class WearStop(NamedTuple):
    """Where surfaces wear in a traced cycle."""

    state: ContactState
    begins: ContactState  #: From which the slip before it starts.
    ends: ContactState  #: At which the slip after it ends.
    approached: ContactState  #: From which its increment started.
    increment: int  #: Its number.
    load_slip: float | None  #: Integral of the load over the slip of which it stands for, N mm; None for its own.
    driven: float | None  #: What the drive moves while the bodies slide of which it stands for, mm; None for all.


def stops_of(start: ContactState, trace: CycleTrace, half_cycle: Mirror | None) -> tuple[WearStop, ...]:
    """Those of a closed cycle traced with the wear frozen from a state on, or of its first half where `half_cycle` maps
    that onto the second.
    """
    worn = trace.worn
    kept = np.arange(len(trace.states)) if worn is None else worn.increments
    again = [state if half_cycle is None else mirrored(state, half_cycle) for state in trace.states[: kept[0] + 1]]
    passed = (start, *trace.states, *again)
    spans = _spans(np.array([bool(state.traction.any()) for state in passed]), kept + 1, len(trace.states))
    stood_for = [(None, None)] * len(spans) if worn is None else list(zip(worn.load_slip, worn.driven, strict=True))
    return tuple(
        WearStop(passed[own], passed[begin], passed[end], passed[own - 1], own - 1, *what)
        for (begin, own, end), what in zip(spans, stood_for, strict=True)
    )


def _spans(pressed: BoolArray, kept: IntArray, count: int) -> list[tuple[int, int, int]]:
    """Of some ends of a cycle's increments, from which end to which the bodies slide before and after: the next ones,
    or where they part and meet in between, for apart they do not slide.

    pressed: (m,) where the bodies touch, from the cycle's start on to the first of `kept` in the next one.  count: of
    increments in a cycle.
    """
    ends = [0, *kept.tolist(), count + int(kept[0])]
    return [
        (
            next((k for k in range(own - 1, before, -1) if not pressed[k]), before),
            own,
            next((k for k in range(own + 1, after) if not pressed[k]), after),
        )
        for before, own, after in zip(ends, ends[1:], ends[2:], strict=False)
    ]


def worn_places(problem: ContactProblem, trace: CycleTrace, count: int) -> WornPlaces:
    """About so many increments of a closed cycle, or of half of one, spread evenly over the slip."""
    states = (trace.start, *trace.states)
    loads = np.array([problem.surface.areas * np.maximum(state.traction[:, 2], 0.0) for state in states])
    slid = np.diff([state.primary_slid for state in states], axis=0)
    weights, load = loads[1:] + loads[:-1], loads.sum(axis=1)
    slip = (slid * weights).sum(axis=1) / np.maximum(weights.sum(axis=1), 1e-300)
    rubbing = np.array([problem.surface.areas * (new.traction + old.traction)[:, 0] for old, new in pairwise(states)])
    ways = -np.sign((rubbing * slid).sum(axis=1)) * slides(slip)
    found = spread_over_slip(ways * slip, 1.0 + load[1:] / float(load.mean()), count)
    kept = np.unique(np.append(np.maximum(np.rint(found), 1.0), len(slip)).astype(np.int64))
    drive = np.where(ways != 0.0, np.abs(np.diff(trace.drive, prepend=trace.start.drive)), 0.0)
    work = 0.5 * (slip + np.roll(slip, -1)) * load[1:]
    shared = [_shared(slip, ways, kept, values) for values in (work, 0.5 * (drive + np.roll(drive, -1)))]
    return WornPlaces(kept - 1, *shared)


def _shared(slip: Array, ways: Array, kept: IntArray, values: Array) -> Array:
    """What of values (m,) at the ends of all increments falls to those that are kept, (k,): between two of them by the
    slip up to either; where the bodies stick, part or turn in between to the one on the same side of that.

    slip: (m,) of each increment.  ways: (m,) its direction, 0 where the bodies do not slide.  kept: (k,) numbers of
    ends, the last of which is the start of the next cycle.
    """
    along, ends, ways = np.append(0.0, np.cumsum(slip)), np.append(0, kept), np.append(ways[-1], ways)
    found = np.zeros(len(ends))
    for k, (begin, end) in enumerate(pairwise(ends)):
        place = np.arange(begin + 1, end + 1)
        other = np.flatnonzero(ways[begin:end] != ways[end])
        if len(other):
            share = (place > begin + other[-1]).astype(float)
        else:
            share = (along[place] - along[begin]) / (along[end] - along[begin])
        found[k] += float((1.0 - share) @ values[place - 1])
        found[k + 1] += float(share @ values[place - 1])
    return np.append(found[1:-1], found[-1] + found[0])
