"""Repair of sample times where the recording clock runs back or ticks more slowly than samples come.

A clock runs back when it wraps around or is reset. A clock that ticks too slowly gives neighbouring samples the same
time; a tick is its smallest step.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Array

#: Where fewer neighbours share a time, rows were doubled; so they were where so many of these read the same otherwise.
LEAST_SHARED, DOUBLED = 0.05, 0.9

GAP = 1.5  #: So many ticks at once are none of a clock that ticks on.

#: Samples from tick to tick differ by no more than so many, or that share of them, unless a gap hides among them.
UNEVEN = 2.0, 0.3


#: Rows are in order where the drive goes on across such a place by no more than so many of its larger steps (the
#: percentile), and by that share of its stroke.
GOES_ON, LARGER_STEPS, OF_STROKE = 3.0, 95.0, 0.02

BACK = "the clock goes back by {:.3g} s{}, as one that wraps or is set again: times were let go on from there"
EVEN = "neighbouring samples share a time, as the clock goes in steps of {:.3g} s: times were set evenly between them"
COARSE = "neighbouring samples share a time: steps of the clock, of {:.3g} s, are too coarse to tell how fast they come"
STILL = "the clock stands still, and tells no time of a sample"


@dataclass(frozen=True, eq=False)
class Clock:
    """Repaired times of n samples, in the order in which they were recorded."""

    time_s: Array | None  #: (n,); None if the clock does not show them.
    note: str = ""  #: Sentence on the repair; "" if none was needed.
    doubt_s: float = 0.0  #: Uncertainty of times across a gap in the log; 0 if there is none.
    gaps: bool = False  #: True if times are unknown and the log has gaps.


def read_clock(time_s: Array, displacement_um: Array, force_N: Array, parts: Sequence[Array] = ()) -> Clock:
    """Repaired times of n samples of displacement and force; time_s: (n,) as recorded, NaN where unknown.

    Where the clock runs back while the drive goes on, later times are shifted so that they go on. Where neighbours
    share a time, samples are spread evenly between gaps in the record. parts: numbers of cycles and of repeats, each
    (n,); where one of them changes, the clock may restart.
    """
    going_on, note = _going_on(time_s, displacement_um, parts)
    clock = _between_ticks(going_on, displacement_um, force_N)
    return replace(clock, note="; ".join(one for one in (note, clock.note) if one))


def _going_on(time_s: Array, displacement_um: Array, parts: Sequence[Array]) -> tuple[Array, str]:
    """Times (n,) shifted to go on wherever the clock runs back but the rows are in order, and a note on it ("" if
    none).
    """
    known = np.flatnonzero(np.isfinite(time_s) & np.isfinite(displacement_um))
    time, x = time_s[known], displacement_um[known]
    steps, moves = np.diff(time), np.abs(np.diff(x))
    back = np.flatnonzero(steps < 0.0)
    # Samples between two places at which a clock goes back are that many or more, on average; else rows are out of
    # order.
    if not back.size or time.size < 8 * (back.size + 1) or not np.any(steps > 0.0):
        return time_s, ""
    usual = float(np.median(steps[steps > 0.0]))
    far = max(GOES_ON * float(np.percentile(moves, LARGER_STEPS)), OF_STROKE * float(np.ptp(x)))
    if np.any(moves[back] > far) or _are_exchanged(time, steps, usual):
        return time_s, ""
    changes = np.zeros(steps.size, dtype=bool)
    for part in parts:
        changes |= np.diff(part[known]) != 0.0
    back = back[~changes[back]]
    if not back.size:
        return time_s, ""
    ahead = np.zeros(time_s.size)
    ahead[known[back + 1]] = usual - steps[back]
    often = f" {back.size} times" if back.size > 1 else ""
    return time_s + np.cumsum(ahead), BACK.format(float(np.median(-steps[back])), often)


def _are_exchanged(time: Array, steps: Array, usual: float) -> bool:
    """True if times (n,) are those of an even clock whose rows were put into another order."""
    values, counts = np.unique(time, return_counts=True)
    between = np.diff(values)
    run = (time.size - 1) / max(int(np.count_nonzero(steps)), 1)
    most = max(run + UNEVEN[0], run * (1.0 + UNEVEN[1])) if run > GAP else 1.0
    return bool(counts.max() <= most and np.all(np.abs(between - usual) < (GAP - 1.0) * usual))


def _between_ticks(time_s: Array, *channels: Array) -> Clock:
    """Times spread evenly between the clock's ticks where neighbouring samples share one; other times are kept."""
    known = np.flatnonzero(np.isfinite(time_s))
    time, steps = time_s[known], np.diff(time_s[known])
    shared = steps == 0.0
    if np.count_nonzero(shared) <= LEAST_SHARED * steps.size:
        return Clock(time_s)
    alike = [np.diff(own[known])[shared] == 0.0 for own in channels]
    if alike and np.count_nonzero(np.all(alike, axis=0)) >= DOUBLED * np.count_nonzero(shared):
        return Clock(time_s)
    if not np.any(steps > 0.0):
        return Clock(None, STILL)
    tick = float(steps[steps > 0.0].min())
    gaps = np.flatnonzero((steps < 0.0) | (steps > GAP * tick)) + 1
    pieces = np.split(np.arange(time.size), gaps)
    changes = [piece[1:][steps[piece[:-1]] > 0.0] for piece in pieces]
    counts = np.concatenate([np.diff(own) for own in changes])
    usual = float(np.median(counts)) if counts.size else 0.0
    most = usual + max(UNEVEN[0], UNEVEN[1] * usual)
    longest = [np.diff([piece[0], *own, piece[-1] + 1]).max() for piece, own in zip(pieces, changes, strict=True)]
    hidden = max(longest) > most or bool(np.any(counts < 2.0 * usual - most))
    if not usual or hidden:
        return Clock(None, COARSE.format(tick), gaps=gaps.size > 0 or (usual > 0.0 and hidden))
    # Numbers of so many digits make larger steps after a power of ten than before.
    elapsed = sum(float(time[own[-1]] - time[own[0]]) for own in changes if own.size)
    step = elapsed / float(counts.sum())
    even = np.full(time_s.size, np.nan)
    for piece, own in zip(pieces, changes, strict=True):
        # A time is passed within the sample before the one that first shows it.
        passed = time[own] - step * (own - 0.5) if own.size else time[piece] + 0.5 * tick - step * piece
        even[known[piece]] = float(np.mean(passed)) + step * piece
    return Clock(even, EVEN.format(tick), step if all(own.size for own in changes) else tick)
