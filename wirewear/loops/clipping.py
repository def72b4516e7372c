"""Channels that ran into the end of their range: samples that all read the same extreme while the others scatter."""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array, BoolArray
from wirewear.loops.noise import through_neighbours
from wirewear.loops.robust import median_deviation

#: So large a share of the samples lies on the steps, within that share of one and half a digit as written: others were
#: put in between. Numbers are written with so many digits after the point at most.
ON_STEPS, WITHIN, DIGITS = 0.95, 1e-3, 9

#: So many samples in a row, and so large a share of all, that read the same extreme are no chance.
FEWEST, LEAST_SHARE = 4, 0.02

FEWEST_PAIRS, FEWEST_LOOP = 10, 32  #: So many neighbours, of a loop of so many samples, tell scatter from a course.
ALTERNATING = -0.4  #: Neighbours' fourth differences that correlate by less than this are noise.
CONSTANT = 1e-5  #: What varies by a smaller share than sixteen bits resolve is constant.
OUTSIDE, NEAR = 3, 3.5  #: An outlier or two may lie beyond the range's end, but not by so few steps, as noise does.

#: Noise and steps of a channel in shares of its extent: without noise a plateau may be flat, within a step it seems so.
LEAST_NOISE, COARSE, FINE = 2e-4, 0.01, 2e-3


def step_of(values: Array) -> float:
    """Least distance of different values (n,) of which all others are multiples; 0 where they have no step."""
    levels = np.unique(values)
    apart = np.diff(levels)
    apart = apart[apart > 1e-9 * max(float(np.abs(levels).max(initial=0.0)), 1e-300)]
    if apart.size == 0:
        return 0.0
    # Written digits make equal steps differ a little, and values that were put in between are few.
    step = float(np.median(apart[apart < 1.5 * np.quantile(apart, 0.05)]))
    # The more steps lie between two levels, the better they must be known to be counted.
    for most in (4.0, 30.0):
        near = apart[apart < (most + 0.5) * step]
        step = float(near.sum() / np.round(near / step).sum())
    counted = np.concatenate([[0.0], np.cumsum(np.round(np.diff(levels) / step))])
    if not counted[-1]:
        return 0.0
    # Over all levels the digits of one step are as good as nothing.
    step, first = np.polyfit(counted, levels, 1).tolist()
    multiples = (values - first) / step
    within = WITHIN + _digit_of(levels) / step
    return step if float(np.mean(np.abs(multiples - np.round(multiples)) < within)) >= ON_STEPS else 0.0


def _digit_of(values: Array) -> float:
    """The last digit with which values (n,) are written, a power of ten; 0 of numbers that are not rounded."""
    for digit in 10.0 ** -np.arange(DIGITS):
        counted = values / digit
        if np.abs(counted - np.round(counted)).max() < WITHIN:
            return float(digit)
    return 0.0


def rounding_noise(step: float) -> float:
    """Standard deviation of what rounding to steps adds to a sample, step/√12.

    Source: Bennett, Bell System Technical Journal 27 (1948) 446.
    """
    return step / float(np.sqrt(12.0))


@dataclass(frozen=True)
class Clipped:
    """The samples (n,) of a channel that read its largest or smallest value, and these values.

    `sure`: whether its steps are too fine for a plateau to lie within one of them.
    """

    samples: BoolArray
    values: tuple[float, ...]
    sure: bool

    @property
    def text(self) -> str:
        """How many read what."""
        count = int(np.count_nonzero(self.samples))
        return f"{count} samples read exactly {' or '.join(f'{value:.6g}' for value in self.values)}"


def clipped(values: Array, beside: Array | None = None) -> Clipped | None:
    """What of a channel (n,) is clipped, on one side or both; None where nothing is.

    A flat plateau of a noiseless loop reads the same value, too: only scatter elsewhere in the channel, or in the one
    that was recorded `beside` it (n,), tells that this cannot be.
    """
    extent = float(np.ptp(values))
    step, levels = step_of(values), np.unique(values)
    # Both ends of its range alone are no steps of a sensor.
    ends_alone = levels.size == 2
    # A constant has no range that could clip it, though rounding, or a simulation's tolerance, varies it.
    if extent <= CONSTANT * float(np.max(np.abs(values))) or (step > COARSE * extent and not ends_alone):
        return None
    found = np.zeros(values.size, dtype=bool)
    # A sine stays within two steps of its end for so long: within its last one, and where noise carries it there.
    turning = float(np.arccos(max(1.0 - 4.0 * step / extent, -1.0)) / np.pi)
    ends = []
    for outermost in (levels[:OUTSIDE], levels[: -OUTSIDE - 1 : -1]):
        for value in (float(level) for level in outermost):
            same = np.abs(values - value) <= 1e-9 * max(abs(value), extent)
            beyond = values[values < value if outermost[0] == levels[0] else values > value]
            if beyond.size > OUTSIDE or (np.abs(beyond - value) < NEAR * step).any():
                break
            if _longest(same) >= FEWEST and np.count_nonzero(same) > max(LEAST_SHARE, turning) * values.size:
                found |= same
                ends.append(value)
                break
    if not ends:
        return None
    known = _scatters(values, found, extent)
    if not known and beside is not None:
        known = _scatters(beside, np.zeros_like(found), float(np.ptp(beside)))
    if not known:
        return None
    return Clipped(found, tuple(ends), ends_alone or step <= FINE * extent)


def _longest(same: BoolArray) -> int:
    """Length of the longest run of a cycle's samples (n,)."""
    if same.all():
        return same.size
    turned = np.roll(same, -int(np.argmin(same)))
    edges = np.flatnonzero(np.diff(np.concatenate([[False], turned, [False]]).astype(int)))
    return int(np.max(edges[1::2] - edges[::2], initial=0))


def _scatters(values: Array, left_out: BoolArray, extent: float) -> bool:
    """Whether what neighbours leave of samples alternates from one to the next, as noise does and no course does."""
    if values.size < FEWEST_LOOP:
        return False
    near = np.lib.stride_tricks.sliding_window_view(np.arange(values.size), 5)
    off = (values - through_neighbours(values[None])[0])[2:-2]
    sound: BoolArray = ~np.any(left_out[near], axis=1)
    pairs = sound[1:] & sound[:-1]
    usual = median_deviation(off[sound])
    if np.count_nonzero(pairs) < FEWEST_PAIRS or usual <= LEAST_NOISE * extent:
        return False
    # Fourth differences of white noise correlate by -0.8; a corner of the course, large there, must not count for more.
    one, other = (np.clip(part[pairs], -3.0 * usual, 3.0 * usual) for part in (off[1:], off[:-1]))
    return float(one @ other) < ALTERNATING * float(np.linalg.norm(one) * np.linalg.norm(other))
