"""Where a drive reverses and where cycles begin, in one row of displacement samples.

A turn is a sample at which the drive reverses, and a sweep is the way between two turns. A ripple is an oscillation of
the drive much smaller than the stroke; a block is a run of cycles with another stroke.
"""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array, BoolArray
from wirewear.loops.noise import sample_noise, step_of

#: A drive has turned once it has come back by so many noises of a sample, and so many of its steps.
NOISES, STEPS = 8.0, 1.5

#: Way back within a sweep that is no turn: by this share of all the displacements, or of the sweeps beside it.
LEAST, WOBBLE = 0.005, 0.25

#: A sweep comes back by this share of the stroke; one that lasts longer than others by the first factor holds a block
#: of smaller strokes, by the second one if these last less than that share of a sweep.
OF_STROKE, LONG, LONGER, BRISK = 0.5, 1.25, 4.5, 0.4

#: A way back of so few samples, within the samples and at their ends, and of so small a share of the usual sweep's, is
#: a spike.
SPIKE, END_SPIKE, BRIEF = 5, 2, 0.15

MOST_CYCLES = 1.25  #: More cycles than this are not one.

#: A last cycle that is cut off counts from this share of its sweeps on, or of the samples of the one before.
WHOLE, LEAST_WHOLE = 0.9, 0.7

Places = NDArray[np.intp]

FEWEST_SLIPS = 4  #: So many single samples that fall alike are slips, and no chance.


def turns_of(displacement_um: Array) -> Places:
    """Turns (k,): indices of the first sample, of every reversal of the drive, and of the last sample, for
    displacements (n,), n ≥ 2. Ripples and spikes are no reversals.
    """
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
    return _without_ripples(calm, turns)


def _without_ripples(x: Array, turns: Places) -> Places:
    """Turns (k,) of a path, without those of ripples that ride on the sweeps.

    Between turns that come back by a good part of the stroke, a ripple lasts no longer than a sweep. A block of smaller
    strokes lasts longer and keeps its turns.
    """
    least = OF_STROKE * float(np.ptp(x[turns]))
    lasts = np.diff(turns[_turns_by(x[turns], least)]).astype(float)
    # The first sweep and the last one may be cut off.
    inner, ends = lasts[1:-1], 4.0 * max(lasts[0], lasts[-1])
    usual = float(np.percentile(inner, 25.0, method="lower")) if inner.size else 0.25 * ends
    usual = min(usual, ends) if inner.size == 1 else usual
    ripple = 0.0

    def parted(sweeps: Places, least: float) -> list[int]:
        """Indices of the turns behind the first one, without those of ripples."""
        nonlocal ripple
        found = list[int]()
        for part in (sweeps[a : b + 1] for a, b in pairwise(_turns_by(x[sweeps], least))):
            last, swing = part[-1] - part[0], float(np.median(np.diff(part)))
            if part.size > 2 and last > (LONG if swing > BRISK * usual else LONGER) * usual:
                found += parted(part, 0.5 * least)
            else:
                found.append(int(part[-1]))
                ripple = max(ripple, float(np.max(np.diff(x[part]) * np.sign(x[part[0]] - x[part[-1]]))))
        return found

    kept = np.array([turns[0], *parted(turns, least)])
    # At the ends, a sweep that is cut off may be none.
    for second in (1, -2):
        if kept.size > 3 and abs(x[kept[second]] - x[kept[0 if second > 0 else -1]]) <= 1.5 * ripple:
            kept = np.delete(kept, second)
    return kept


def _turns_by(levels: Array, least: float) -> Places:
    """Indices of the first and last level (k,), of turns that come back by at least `least`, and of outermost levels at
    ends.
    """
    found, low, high, way = [0], 0, 0, 0
    for place, level in enumerate(levels.tolist()):
        low, high = low if levels[low] <= level else place, high if levels[high] >= level else place
        if way >= 0 and levels[high] - level >= least:
            found, low, way = [*found, high], place, -1
        elif way <= 0 and level - levels[low] >= least:
            found, high, way = [*found, low], place, 1
    outermost = [] if not way else [high] if way > 0 else [low]
    return np.array(sorted({*found, *outermost, levels.size - 1}))


def cycles_between(displacement_um: Array, turns: Places) -> float:
    """Number of cycles between the first and the last of the turns (k,), indices into displacements (n,); each full
    sweep counts as half a cycle, those at the ends by their length.
    """
    swings = np.abs(np.diff(_without_spikes(displacement_um)[turns]))
    if swings.size < 2:
        return 0.5
    ends = min(swings[0] / max(swings[1], 1e-300), 1.0) + min(swings[-1] / max(swings[-2], 1e-300), 1.0)
    return 0.5 * float(swings.size - 2 + ends)


def cycle_starts(displacement_um: Array, turns: Places) -> Places:
    """Indices (c,) at which cycles begin: where the drive passes the first sample's displacement again in the same
    direction; if the first sample lies at a reversal, at every second turn.

    turns: (k,) of the displacements (n,), as by `turns_of`.
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
    # A first sample as far out as this share of the amplitude, going inwards, is at a reversal.
    if out < -0.995:
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
    """Slices of displacements (n,) in order of time, one for each whole cycle; one slice of all samples if they are at
    most a cycle and a quarter.

    Cycles may differ in amplitude. An incomplete last cycle is left out.
    """
    turns = turns_of(displacement_um)
    if cycles_between(displacement_um, turns) <= MOST_CYCLES:
        return [slice(0, displacement_um.size)]
    starts = [int(start) for start in cycle_starts(displacement_um, turns)]
    parts = [slice(a, b) for a, b in zip(starts, [*starts[1:], displacement_um.size], strict=True)]
    return parts if len(parts) < 2 or _is_whole(displacement_um[parts[-1]], parts[-2]) else parts[:-1]


def _is_whole(last: Array, before: slice) -> bool:
    """True if the last samples make a whole cycle; `before` is the slice of the cycle before them."""
    share = last.size / (before.stop - before.start)
    if share < LEAST_WHOLE:
        return False
    swept = cycles_between(last, turns_of(last))
    return swept >= WHOLE or (swept >= LEAST_WHOLE and share >= WHOLE)


def _without_spikes(values: Array) -> Array:
    """Running medians of five samples (n,), which one or two outliers do not move."""
    if values.size < 8:
        return values
    middle = np.median(np.lib.stride_tricks.sliding_window_view(values, 5), axis=1)
    reach = 3.0 * float(np.percentile(np.abs(np.diff(middle)), 90)) if middle.size > 1 else 0.0
    ends = [middle[at] + np.clip(part - middle[at], -reach, reach) for at, part in ((0, values[:2]), (-1, values[-2:]))]
    return np.concatenate([ends[0], middle, ends[1]])


def signal_among(flagged: BoolArray, force: Array, time: Array, noise: float) -> BoolArray:
    """(n,) True for forces (n,) of a closed loop that were flagged as outliers but belong to the signal: slips, jumps
    or points on a line.

    flagged: (n,) not changed. time: (n,). noise: standard deviation of one force.
    """
    middle = 0.5 * float(np.percentile(force, 5) + np.percentile(force, 95))
    kept = _alike_dips(force, flagged, middle) | _usual_jumps(force, flagged, middle)
    for sample in np.flatnonzero(flagged & ~kept):
        kept[sample] = continues_a_line(time, force, int(sample), noise)
    return kept


def continues_a_line(time: Array, force: Array, sample: int, noise: float) -> bool:
    """True if the sample of index `sample` of a closed loop lies on the line of the three samples before it or of the
    three after it, to within 4 noise and a tenth of its jump.

    The tip of a stick stretch and the first sample after a slip do so, an outlier does not.
    """
    count = len(force)
    period = (time[-1] - time[0]) * count / (count - 1)
    for side in (-1, 1):
        near = (sample + side * np.arange(1, 4)) % count
        t = side * ((side * (time[near] - time[sample])) % period)
        if np.ptp(t) <= 0.0:
            continue
        slope, level = np.polyfit(t, force[near], 1)
        rest = float(np.abs(force[near] - level - slope * t).max())
        jump = abs(force[sample] - force[(sample - side) % count])
        near_enough = 4.0 * noise + 0.1 * jump
        if rest <= near_enough and abs(force[sample] - level) <= near_enough + rest:
            return True
    return False


def _alike_dips(force: Array, flagged: BoolArray, middle: float) -> BoolArray:
    """Flagged forces (n,) that fall towards the loop's middle but not across it; none unless four or more do
    (slips).
    """
    size = np.abs(force - middle)
    level = float(np.percentile(size, 60))
    before, after = np.roll(force, 1), np.roll(force, -1)
    sides = np.sign(np.stack([before, force, after]) - middle)
    same_side = (sides[0] == sides[1]) & (sides[2] == sides[1])
    dips = flagged & same_side & (size < 0.97 * level) & (size > 0.1 * level)
    return dips if np.count_nonzero(dips) >= FEWEST_SLIPS else np.zeros_like(flagged)


def _usual_jumps(force: Array, flagged: BoolArray, middle: float) -> BoolArray:
    """Flagged forces (n,) within their branch's range, reached by a jump as large as four or more other jumps."""
    rest = force[~flagged]
    steps = np.diff(rest, prepend=rest[-1])
    # A stiff rig's reversals jump, too, twice in every loop.
    jumps = np.sort(np.abs(steps[~_of_reversals(rest - middle, steps)]))
    own = np.minimum(np.abs(force - np.roll(force, 1)), np.abs(np.roll(force, -1) - force))
    often = jumps.size - np.searchsorted(jumps, 0.7 * own) >= FEWEST_SLIPS
    far = np.abs(force - middle)
    inside = (far <= np.abs(rest - middle).max()) & (far >= 0.1 * np.abs(rest - middle).max())
    usual: BoolArray = flagged & often & inside
    return usual


def _of_reversals(away: Array, steps: Array) -> BoolArray:
    """Mark the steps (n,) that lead from one plateau to the other; `away` is the force less the loop's middle."""
    # A way from one side of the loop to the other is a reversal if it begins and ends beyond this share of the
    # plateaus.
    least = 0.5 * float(np.percentile(np.abs(away), 60))
    # Runs of steps one way, of a loop that begins where one ends.
    first = int(np.argmax(np.sign(steps) != np.sign(np.roll(steps, 1))))
    signs = np.sign(np.roll(steps, -first))
    starts = np.flatnonzero(np.diff(signs, prepend=np.nan) != 0.0)
    found = np.zeros(steps.size, dtype=bool)
    for start, end in zip(starts, [*starts[1:], steps.size], strict=True):
        before, after = (away[(first + at) % away.size] for at in (start - 1, end - 1))
        if before * after < 0.0 and min(abs(before), abs(after)) > least:
            found[(first + np.arange(start, end)) % steps.size] = True
    return found
