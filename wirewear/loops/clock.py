"""Times of samples that come faster than the clock beside them ticks, so that neighbours share one."""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array

#: Where fewer neighbours share a time, rows were doubled; so they were where so many of these read the same otherwise.
LEAST_SHARED, DOUBLED = 0.05, 0.9

GAP = 1.5  #: So many ticks at once are none of a clock that ticks on.

#: Samples from tick to tick differ by no more than so many, or that share of them, unless a gap hides among them.
UNEVEN = 2.0, 0.3

EVEN = "neighbouring samples share a time, as the clock goes in steps of {:.3g} s: times were set evenly between them"
COARSE = "neighbouring samples share a time: steps of the clock, of {:.3g} s, are too coarse to tell how fast they come"
STILL = "the clock stands still, and tells no time of a sample"


@dataclass(frozen=True, eq=False)
class Clock:
    """Times of samples, in the order in which they came."""

    time_s: Array | None  #: (n,); None where the clock does not tell them.
    note: str = ""  #: What was found or done, "" of a clock that is fine enough.
    doubt_s: float = 0.0  #: By how much times on either side of a gap may be off each other.
    gaps: bool = False  #: Of a clock that is too coarse, whether the log has gaps.


def read_clock(time_s: Array, *channels: Array) -> Clock:
    """The clock behind times (n,), NaN where none is known, of samples of other channels (n,).

    Where neighbours share a time, samples come evenly from one gap to the next.
    """
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
    step = tick * counts.size / float(counts.sum())
    even = np.full(time_s.size, np.nan)
    for piece, own in zip(pieces, changes, strict=True):
        # A time is passed within the sample before the one that first shows it.
        passed = time[own] - step * (own - 0.5) if own.size else time[piece] + 0.5 * tick - step * piece
        even[known[piece]] = float(np.mean(passed)) + step * piece
    return Clock(even, EVEN.format(tick), step if all(own.size for own in changes) else tick)
