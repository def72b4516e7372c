"""Where a drive turns round, how many cycles the samples hold, and where one ends and the next begins."""

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array
from wirewear.loops.noise import sample_noise, step_of

#: A drive has turned once it has come back by so many noises of a sample, and so many of its steps.
NOISES, STEPS = 8.0, 1.5

#: Way back within a sweep that is no turn: by this share of all the displacements, or of the sweeps beside it.
LEAST, WOBBLE = 0.005, 0.25

#: A way back of so few samples, within the samples and at their ends, and of so small a share of the usual sweep's, is
#: a spike.
SPIKE, END_SPIKE, BRIEF = 5, 2, 0.15

AT_REVERSAL = 0.995  #: A first sample as far out as this share of the amplitude, going inwards, is at a reversal.
MOST_CYCLES = 1.25  #: More cycles than this are not one.

#: A last cycle that is cut off counts from this share of its sweeps on, or of the samples of the one before.
WHOLE, LEAST_WHOLE = 0.9, 0.7

Places = NDArray[np.intp]


def turns_of(displacement_um: Array) -> Places:
    """First sample, every sample at which the drive turns round, and last sample of samples (n,) in order, n ≥ 2."""
    calm = _without_spikes(displacement_um)
    places = np.arange(calm.size)
    noise = sample_noise(displacement_um, places.astype(float)) if calm.size > 8 else 0.0
    least = max(NOISES * noise, STEPS * step_of(displacement_um), LEAST * float(np.ptp(calm)))
    way = np.sign(np.diff(calm))
    moving = np.flatnonzero(way)
    turning = moving[1:][way[moving[1:]] != way[moving[:-1]]]
    turns = np.concatenate([[0], turning, [calm.size - 1]])
    while turns.size > 3:
        swings = np.abs(np.diff(calm[turns]))
        inner, before, after = swings[1:-1], swings[:-2], swings[2:]
        small = (inner < before) & (inner <= after) & (inner < np.maximum(least, WOBBLE * np.minimum(before, after)))
        lasts = np.diff(turns)
        usual = np.sum(lasts**2) / np.sum(lasts)
        if not small.any():
            short = (lasts[1:-1] <= np.minimum(SPIKE, BRIEF * usual)) & (lasts[1:-1] < lasts[:-2])
            small = short & ~np.roll(short, 1)
        if small.any():
            gone = np.flatnonzero(small) + 1
            turns = np.delete(turns, np.concatenate([gone, gone + 1]))
        elif swings[0] < least or lasts[0] <= min(END_SPIKE, BRIEF * usual):
            turns = np.delete(turns, 1)
        elif swings[-1] < least or lasts[-1] <= min(END_SPIKE, BRIEF * usual):
            turns = np.delete(turns, -2)
        else:
            break
    return turns


def cycles_between(displacement_um: Array, turns: Places) -> float:
    """How many cycles lie between the first of these turns and the last: a whole sweep is half of one."""
    swings = np.abs(np.diff(_without_spikes(displacement_um)[turns]))
    if swings.size < 2:
        return 0.5
    ends = min(swings[0] / max(swings[1], 1e-300), 1.0) + min(swings[-1] / max(swings[-2], 1e-300), 1.0)
    return 0.5 * float(swings.size - 2 + ends)


def cycle_starts(displacement_um: Array, turns: Places) -> Places:
    """Samples at which a cycle begins: where the drive passes the place of the first sample again, the same way.

    A first sample at a reversal makes them all begin at reversals.
    """
    x = _without_spikes(displacement_um)
    if turns.size < 3:
        return turns[:1]
    if turns.size == 3:
        centre = 0.5 * float(x[turns].max() + x[turns].min())
    else:
        centre = float(np.median(0.5 * (x[turns[1:-2]] + x[turns[2:-1]])))
    way = np.sign(x[turns[1]] - x[0])
    out = way * (x[0] - centre) / max(abs(x[turns[1]] - centre), 1e-300)
    if out < -AT_REVERSAL:
        return turns[:-1:2]
    starts = [0]
    for begin, end in zip(turns[2:-1:2], turns[3::2], strict=False):
        ahead = way * (x[begin : end + 1] - x[0])
        passed = int(np.argmax(ahead >= 0.0))
        if ahead[passed] < 0.0:
            # A drive that moved away meanwhile, or one that stops before.
            passed = ahead.size - 1
            if end == turns[-1]:
                break
        nearer = passed > 0 and -ahead[passed - 1] < ahead[passed]
        starts.append(int(begin) + passed - int(nearer))
    return np.array(starts)


def split_cycles(displacement_um: Array) -> list[slice]:
    """The whole cycles of samples (n,) in order of time, each of its own amplitude; all samples where there is one."""
    turns = turns_of(displacement_um)
    if cycles_between(displacement_um, turns) <= MOST_CYCLES:
        return [slice(0, displacement_um.size)]
    starts = [int(start) for start in cycle_starts(displacement_um, turns)]
    parts = [slice(a, b) for a, b in zip(starts, [*starts[1:], displacement_um.size], strict=True)]
    return parts if len(parts) < 2 or _is_whole(displacement_um[parts[-1]], parts[-2]) else parts[:-1]


def _is_whole(last: Array, before: slice) -> bool:
    """Whether the last samples are a cycle, the one before being those of the slice."""
    share = last.size / (before.stop - before.start)
    if share < LEAST_WHOLE:
        return False
    swept = cycles_between(last, turns_of(last))
    return swept >= WHOLE or (swept >= LEAST_WHOLE and share >= WHOLE)


def _without_spikes(values: Array) -> Array:
    """Medians of five neighbours (n,), which one or two outliers do not move; the ends stay near their neighbours."""
    if values.size < 8:
        return values
    middle = np.median(np.lib.stride_tricks.sliding_window_view(values, 5), axis=1)
    reach = 3.0 * float(np.percentile(np.abs(np.diff(middle)), 90)) if middle.size > 1 else 0.0
    ends = [middle[at] + np.clip(part - middle[at], -reach, reach) for at, part in ((0, values[:2]), (-1, values[-2:]))]
    return np.concatenate([ends[0], middle, ends[1]])
