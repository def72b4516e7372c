"""Samples that stand out of their neighbours and are signal: tips of stick-slip, static peaks, short slips."""

import numpy as np
from numpy.typing import NDArray

from wirewear.loops.robust import Array

#: So many single samples that fall alike are slips, and no chance.
FEWEST_SLIPS = 4

#: A way from one side of the loop to the other is a reversal if it begins and ends beyond this share of the plateaus.
OF_PLATEAU = 0.5


def signal_among(flagged: NDArray[np.bool_], force: Array, time: Array, noise: float) -> NDArray[np.bool_]:
    """Which of the forces (n,) of a closed loop that were flagged as outliers are none."""
    middle = 0.5 * float(np.percentile(force, 5) + np.percentile(force, 95))
    kept = _alike_dips(force, flagged, middle) | _usual_jumps(force, flagged, middle)
    for sample in np.flatnonzero(flagged & ~kept):
        kept[sample] = _continues_a_line(time, force, int(sample), noise)
    return kept


def _continues_a_line(time: Array, force: Array, sample: int, noise: float) -> bool:
    """Whether a sample of a closed loop goes on as those before it do, or those after it go on from it.

    So do the tip of a stick and the first sample after a slip, but no outlier.
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


def _alike_dips(force: Array, flagged: NDArray[np.bool_], middle: float) -> NDArray[np.bool_]:
    """Flagged forces (n,) that fall towards the loop's middle, not beyond it, and are many: slips of one sample."""
    size = np.abs(force - middle)
    level = float(np.percentile(size, 60))
    before, after = np.roll(force, 1), np.roll(force, -1)
    sides = np.sign(np.stack([before, force, after]) - middle)
    same_side = (sides[0] == sides[1]) & (sides[2] == sides[1])
    dips = flagged & same_side & (size < 0.97 * level) & (size > 0.1 * level)
    return dips if np.count_nonzero(dips) >= FEWEST_SLIPS else np.zeros_like(flagged)


def _usual_jumps(force: Array, flagged: NDArray[np.bool_], middle: float) -> NDArray[np.bool_]:
    """Flagged forces (n,) within the range of their branch, to which the others jump as far many times."""
    rest = force[~flagged]
    steps = np.diff(rest, prepend=rest[-1])
    # A stiff rig's reversals jump, too, twice in every loop.
    jumps = np.sort(np.abs(steps[~_of_reversals(rest - middle, steps)]))
    own = np.minimum(np.abs(force - np.roll(force, 1)), np.abs(np.roll(force, -1) - force))
    often = jumps.size - np.searchsorted(jumps, 0.7 * own) >= FEWEST_SLIPS
    far = np.abs(force - middle)
    inside = (far <= np.abs(rest - middle).max()) & (far >= 0.1 * np.abs(rest - middle).max())
    usual: NDArray[np.bool_] = flagged & often & inside
    return usual


def _of_reversals(away: Array, steps: Array) -> NDArray[np.bool_]:
    """Which steps (n,) to samples of a closed loop, so far from its middle (n,), lead from one plateau to the other."""
    least = OF_PLATEAU * float(np.percentile(np.abs(away), 60))
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
