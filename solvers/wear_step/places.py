"""At which increments of a cycle surfaces wear (stops), and from where to where the bodies slide before and after each.

Where load or bulk stress change within a cycle, many increments follow how the contact sticks and slides; as many stops
would make the equations of a jump many times as large. Those that are kept stand for the work of the others, too: work
between two of them is shared by how near to either it was done along the slip, so that none is lost.
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

# Of the mean load, or of the largest under which the bodies slide: no place with less stands for others, which would
# wear so little of the surface.
_LEAST_LOAD = 0.1


class WearStop(NamedTuple):
    """An increment of a traced cycle at whose end wear is computed; it may stand for wear of increments near it."""

    state: ContactState  #: At the end of the increment.
    begins: ContactState  #: From which the bodies slide to `state`: of the stop before, or where they last met.
    ends: ContactState  #: To which they slide afterwards: of the next stop, or where they part.
    approached: ContactState  #: At the start of the increment.
    increment: int  #: Its index in the trace, from 0.
    load_slip: float | None  #: Load times slip, N mm, of all increments for which it stands; None if for its own only.
    driven: float | None  #: Motion of the drive, mm, while the bodies slide in those increments; None as before.

    @property
    def legs(self) -> tuple[tuple[ContactState, ContactState], ...]:
        """Pairs (from, to) of states between which the bodies slide: up to the stop, on from it, and, only if its
        increment did not start in `begins`, over its increment.
        """
        around = (self.begins, self.state), (self.state, self.ends)
        return around if self.approached is self.begins else (*around, (self.approached, self.state))


def stops_of(start: ContactState, trace: CycleTrace, half_cycle: Mirror | None) -> tuple[WearStop, ...]:
    """The stops of a traced closed cycle, in order: all its increments, or those of `trace.worn`.

    start: the state from which the cycle was traced, with the worn depths held fixed. half_cycle: the mirror that maps
    the first half of the cycle onto the second; the trace, and the stops, then cover the first half only. None: a whole
    cycle.
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
    """From which to which end of increments the bodies slide before and after each of some ends: the next ones,
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
    """About `count` increments of a closed cycle, or of half of one, at whose ends surfaces wear: spread evenly over
    the load-weighted slip, with the last one always among them. Each has its share of the whole trace's load times slip
    and of the drive's motion.
    """
    states = (trace.start, *trace.states)
    load = np.array([float(problem.surface.areas @ state.traction[:, 2]) for state in states])
    slip = trace.slips
    ways = np.sign(slip) * slides(slip)
    mean = float(load.mean())
    found = np.maximum(np.rint(spread_over_slip(slip, 1.0 + load[1:] / mean, count)), 1.0).astype(np.int64)
    # An increment in which the bodies part wears where it begins.
    found = np.maximum(found - (load[found] <= 0.0), 1)
    found = found[load[found] > _LEAST_LOAD * min(mean, float(load[found].max(initial=0.0)))]
    kept = np.unique(np.append(found if len(found) else 1 + np.argmax(load[1:]), len(slip)))
    drive = np.where(ways != 0.0, np.abs(np.diff(trace.drive, prepend=trace.start.drive)), 0.0)
    work = 0.5 * (np.abs(slip) + np.abs(np.roll(slip, -1))) * load[1:]
    if load[-1] <= _LEAST_LOAD * mean:
        ways[-1] = 0.0
    shared = [_shared(slip, ways, kept, values) for values in (work, 0.5 * (drive + np.roll(drive, -1)))]
    return WornPlaces(kept - 1, *shared)


def _shared(slip: Array, ways: Array, kept: IntArray, values: Array) -> Array:
    """What of values (m,) at the ends of all increments falls to those that are kept, (k,): between two of them by the
    slip up to either; where the bodies stick, part or turn in between to the one on the same side of that.

    slip: (m,) of each increment.  ways: (m,) its sign, 0 where the bodies do not slide.  kept: (k,) numbers of
    ends, the last of which is the start of the next cycle.
    """
    along, ends, ways = np.append(0.0, np.cumsum(np.abs(slip))), np.append(0, kept), np.append(ways[-1], ways)
    found = np.zeros(len(ends))
    for k, (begin, end) in enumerate(pairwise(ends)):
        place = np.arange(begin + 1, end + 1)
        other = np.flatnonzero(ways[begin:end] != ways[end])
        if len(other):
            share = (place > begin + other[-1]).astype(float)
        else:
            share = (along[place] - along[begin]) / max(along[end] - along[begin], 1e-300)
        found[k] += float((1.0 - share) @ values[place - 1])
        found[k + 1] += float(share @ values[place - 1])
    # Where the bodies do not slide at its end, a cycle begins with what its first place stands for.
    whole = found[0] + found[-1]
    found[-1] = 0.0
    found[-1 if ways[-1] else 1] += whole
    return found[1:]
