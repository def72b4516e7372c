"""Noise of samples, outliers among them, and channels clipped at the end of their range.

Noise is white, or a first-order autoregression with correlation ρ between neighbours. Its stretch √((1+ρ)/(1−ρ)) is the
factor by which ρ raises the error of a mean of many samples.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from geometry.arrays import Array, BoolArray
from wirewear.loops.robust import median_deviation

TRIED = np.arange(0.0, 0.91, 0.05)  #: Correlations of neighbours that are tried.

#: A stated noise is what one expects within this relative deviation, of a Student's t that lets wrong statements be.
STATED_WITHIN, STATED_FREEDOM = 0.3, 3.0


#: The cubic through two neighbours on either side, at even times: a sample is their mean with these weights.
NEIGHBOURS, WEIGHTS = (-2, -1, 1, 2), np.array([-1.0, 4.0, 4.0, -1.0]) / 6.0

#: By what a sample's distance to that cubic scatters more than the sample itself.
_SCATTER = float(np.sqrt(1.0 + np.sum(WEIGHTS**2)))

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


def correlated_noise(
    parts: Sequence[tuple[Array, Array]], stated: float | None, rounding: float = 0.0
) -> tuple[float, float]:
    """Standard deviation of one sample of an AR(1) noise, and its stretch √((1+ρ)/(1−ρ)).

    parts: pairs of a design (m, k) of smooth curves and samples (m,) that follow these but for noise, which is alike in
    all parts. stated: deviation that the record states for a sample; None if it states none. rounding: deviation of
    white noise added by rounding. The curves absorb some of the slow noise; restricted likelihood corrects for that.

    Source: Patterson & Thompson, Biometrika 58 (1971) 545, for a first-order autoregression.
    """
    found = [_likeliest(*_restricted(parts, float(correlation)), stated) for correlation in TRIED]
    best = int(np.argmax([likelihood for likelihood, _ in found]))
    highest, deviation = found[best]
    stretch = stretch_of(float(TRIED[best]))
    # Rounding of less than this share of a sample's noise is left in it: written digits are steps, too.
    if 0.1 * deviation < rounding < deviation:
        under = float(np.sqrt(deviation**2 - rounding**2))
        share = (rounding / under) ** 2
        rounded = [_likeliest(*_rounded(parts, float(correlation), share), stated) for correlation in TRIED]
        best = int(np.argmax([likelihood for likelihood, _ in rounded]))
        if rounded[best][0] > highest:
            under, correlated = rounded[best][1], stretch_of(float(TRIED[best]))
            deviation = under * float(np.sqrt(1.0 + share))
            stretch = float(np.sqrt((correlated**2 + share) / (1.0 + share)))
    return deviation, stretch


def _rounded(parts: Sequence[tuple[Array, Array]], correlation: float, share: float) -> tuple[float, int, float]:
    """Results of `_restricted` with white noise of `share` times the autoregression's variance added."""
    squares, free, determinants = 0.0, 0, 0.0
    for design, values in parts:
        apart = np.abs(np.subtract.outer(np.arange(values.size), np.arange(values.size)))
        factor = np.linalg.cholesky(correlation**apart + share * np.eye(values.size))
        upper = np.linalg.qr(solve_triangular(factor, np.column_stack([design, values]), lower=True), mode="r")
        size = np.abs(np.diag(upper))
        squares += float(size[-1] ** 2)
        free += values.size - design.shape[1]
        determinants += float(np.log(np.maximum(size[:-1], 1e-300)).sum() + np.log(np.diag(factor)).sum())
    return max(squares / free, 1e-300), free, -determinants


def _restricted(parts: Sequence[tuple[Array, Array]], correlation: float) -> tuple[float, int, float]:
    """Mean square of the noise, degrees of freedom, and the term of determinants in the restricted log-likelihood.

    parts: as for `correlated_noise`.  correlation: between neighbouring samples.
    """
    squares, free, determinants = 0.0, 0, 0.0
    for design, values in parts:
        columns = np.column_stack([design, values])
        columns[1:] = (columns[1:] - correlation * columns[:-1]) / np.sqrt(1.0 - correlation**2)
        upper = np.linalg.qr(columns, mode="r")
        size = np.abs(np.diag(upper))
        squares += float(size[-1] ** 2)
        free += values.size - design.shape[1]
        determinants += float(np.log(np.maximum(size[:-1], 1e-300)).sum())
        determinants += 0.5 * (values.size - 1) * float(np.log1p(-(correlation**2)))
    return max(squares / free, 1e-300), free, -determinants


def _likeliest(variance: float, free: int, determinants: float, stated: float | None) -> tuple[float, float]:
    """Largest log-likelihood over the standard deviation, given a stated one if any, and that deviation."""
    level = 0.5 * float(np.log(variance))
    if not stated:
        return determinants - free * (level + 0.5), float(np.sqrt(variance))
    expected, at = float(np.log(stated)), level
    for _ in range(20):
        # Newton's method for the normal that touches Student's t where the last step has led.
        weight = (STATED_FREEDOM + 1.0) / (STATED_FREEDOM * STATED_WITHIN**2 + (at - expected) ** 2)
        ratio = free * variance * float(np.exp(-2.0 * at))
        at -= (free - ratio + weight * (at - expected)) / (2.0 * ratio + weight)
    likelihood = -free * at - 0.5 * free * variance * float(np.exp(-2.0 * at))
    surprise = 0.5 * (STATED_FREEDOM + 1.0) * float(np.log1p(((at - expected) / STATED_WITHIN) ** 2 / STATED_FREEDOM))
    return determinants + likelihood - surprise, float(np.exp(at))


def noise_factor(weights: Array, order: NDArray[np.intp], correlation: float) -> float:
    """Standard deviation of a weighted sum of m samples of one branch, over that of one sample.

    weights: (m,). order: (m,) numbers of the samples along their branch. correlation: between neighbours (AR(1)).
    """
    if correlation <= 0.0:
        return float(np.linalg.norm(weights))
    return float(np.sqrt(noise_product(weights, order, weights, order, correlation)))


def noise_product(
    weights: Array, order: NDArray[np.intp], others: Array, their_order: NDArray[np.intp], correlation: float
) -> float:
    """Covariance of two weighted sums over samples of one branch, over the variance of one sample.

    weights, order: weights and sample numbers (m,) of the first sum; others, their_order: (k,) of the second.
    correlation: between neighbours (AR(1)); a negative one counts as 0.
    """
    apart = np.abs(order[:, None] - their_order)
    return float(weights @ np.where(apart == 0, 1.0, max(correlation, 0.0) ** apart) @ others)


def correlation_of(stretch: float) -> float:
    """Correlation of neighbours that has this stretch; inverse of `stretch_of`."""
    return (stretch**2 - 1.0) / (stretch**2 + 1.0)


def correlation_of_neighbours(factor: float, most: float) -> float:
    """Correlation, from 0 to `most`, at which `noise_of_neighbours` gives this factor, or comes nearest to it."""
    from scipy.optimize import brentq

    within = float(np.clip(factor, noise_of_neighbours(0.0), noise_of_neighbours(most)))
    return float(brentq(lambda correlation: noise_of_neighbours(correlation) - within, 0.0, most))


def stretch_of(correlation: float) -> float:
    """Stretch √((1+ρ)/(1−ρ)) for the correlation ρ of neighbours."""
    return float(np.sqrt((1.0 + correlation) / (1.0 - correlation)))


def noise_of_neighbours(correlation: float) -> float:
    """True noise of a sample over its estimate from the distance to the cubic through four neighbours, which takes
    neighbours as uncorrelated; above 1 for a positive correlation.
    """
    weights = np.append(-WEIGHTS, 1.0)
    return float(np.linalg.norm(weights)) / noise_factor(weights, np.array([*NEIGHBOURS, 0]), correlation)


def through_neighbours(loops: Array) -> Array:
    """(m, n) value, at each sample of closed loops (m, n) evenly sampled, of the cubic through its four neighbours."""
    parts = (weight * np.roll(loops, -shift, axis=1) for shift, weight in zip(NEIGHBOURS, WEIGHTS, strict=True))
    return np.asarray(sum(parts))


def noises(loops: Array) -> Array:
    """(m,) robust standard deviation of one sample of each of m closed loops (m, n) sampled at even times."""
    return 1.4826 * np.median(np.abs(loops - through_neighbours(loops)), axis=1) / _SCATTER


def sample_noise(values: Array, time: Array) -> float:
    """Robust standard deviation of one sample of a signal (n,), from its distance to the cubic through four neighbours,
    at any times (n,); 1 % of the range if fewer than four samples can be used.
    """
    count = len(values)
    centre = np.arange(2, count - 2)
    offsets = np.array([-2, -1, 1, 2])
    distance = time[centre[:, None] + offsets] - time[centre, None]
    weights = np.ones_like(distance)
    # times that all but coincide give weights that are not finite, and those samples are left out below
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for j in range(4):
            for k in range(4):
                if k != j:
                    weights[:, j] *= distance[:, k] / (distance[:, k] - distance[:, j])
    # very uneven spacing would extrapolate wildly: such samples say nothing
    sound = np.max(np.abs(weights), axis=1) < 3.0
    if np.count_nonzero(sound) < 4:
        return float(np.ptp(values)) * 1e-2
    centre, weights = centre[sound], weights[sound]
    prediction = np.sum(weights * values[centre[:, None] + offsets], axis=1)
    error = (values[centre] - prediction) / np.sqrt(1.0 + np.sum(weights**2, axis=1))
    rough = median_deviation(error)
    usual = error[np.abs(error) <= 3.0 * rough]
    # the median alone scatters by a tenth; the bulk is sharper, and 0.9867 restores what its cut tails hold
    return float(np.sqrt(np.mean(usual**2)) / 0.9867) if len(usual) else rough


def noise_along(values: Array) -> float:
    """Robust standard deviation of one sample of a branch (n,), from its distance to the mean of both neighbours."""
    return median_deviation(values[1:-1] - 0.5 * (values[:-2] + values[2:])) / float(np.sqrt(1.5))


def outliers(values: Array, time: Array) -> BoolArray:
    """(n,) True for samples of a closed loop, at times (n,), that lie outside the range between the medians of their
    three neighbours on either side by more than 5 noises and 2.5 steps.

    The second smallest of the four steps between neighbours counts, as an outlier among them spoils two; below 100
    samples it is the mean of the two middle ones, because a hook at a reversal is then as steep as an outlier.
    """
    extent = float(np.subtract(*np.percentile(values, [99, 1])))
    # Samples of a cycle from which on those next to a reversal's hook resolve it.
    noise, dense = sample_noise(values, time), len(values) >= 100

    def allowed(steps: Array) -> Array:
        step = steps[1] if dense else 0.5 * (steps[1] + steps[2])
        return np.asarray(5.0 * noise + 2.5 * step + 1e-9 * extent)

    return np.asarray(outside_neighbours(values[None], allowed)[0])


def outside_neighbours(loops: Array, allowed: Callable[[Array], Array]) -> BoolArray:
    """(m, n) True for samples of closed loops (m, n) outside the range between the medians of three neighbours on
    either side.

    allowed: from the sizes of the four steps between neighbours (4, m, n), sorted from small to large, to the margin
    (m, n) by which that range is widened.
    """
    left = [np.roll(loops, shift, axis=1) for shift in (1, 2, 3)]
    right = [np.roll(loops, -shift, axis=1) for shift in (1, 2, 3)]
    one, other = np.median(left, axis=0), np.median(right, axis=0)
    steps = np.abs([left[1] - left[0], left[2] - left[1], right[1] - right[0], right[2] - right[1]])
    allowance = allowed(np.sort(steps, axis=0))
    outside: BoolArray = (loops < np.minimum(one, other) - allowance) | (loops > np.maximum(one, other) + allowance)
    return outside


def median_in_steps(values: Array) -> float:
    """Median of values (n,); of values in steps that of what was rounded to them, as if it lay evenly within each.

    Of a converter whose steps are as large as the noise, the value in the middle alone jumps from step to step.
    """
    levels, counts = np.unique(values, return_counts=True)
    return float(np.interp(0.5 * values.size, np.cumsum(counts) - 0.5 * counts, levels))


def step_of(values: Array) -> float:
    """Resolution of a channel (n,): the smallest distance of which its values are multiples; 0 if they have none."""
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
    away = counted - counted.mean()
    step = float(away @ levels / (away @ away))
    multiples = (values - levels.mean()) / step + counted.mean()
    within = WITHIN + _digit_of(levels) / step
    return step if float(np.mean(np.abs(multiples - np.round(multiples)) < within)) >= ON_STEPS else 0.0


def _digit_of(values: Array) -> float:
    """Power of ten of the last digit with which values (n,) are written; 0 for numbers that are not rounded."""
    for digit in 10.0 ** -np.arange(DIGITS):
        counted = values / digit
        if np.abs(counted - np.round(counted)).max() < WITHIN:
            return float(digit)
    return 0.0


def rounding_noise(step: float) -> float:
    """Standard deviation step/√12 of what rounding to multiples of `step` adds to a sample.

    Source: Bennett, Bell System Technical Journal 27 (1948) 446.
    """
    return step / float(np.sqrt(12.0))


@dataclass(frozen=True)
class Clipped:
    """Samples (n,) of a channel that read its largest or smallest value, marked True, and the values that they read.

    sure: False where the channel's steps are so coarse that a plateau may lie within one of them.
    """

    samples: BoolArray
    values: tuple[float, ...]
    sure: bool

    @property
    def text(self) -> str:
        """Part of a sentence: how many samples read which value."""
        count = int(np.count_nonzero(self.samples))
        return f"{count} samples read exactly {' or '.join(f'{value:.6g}' for value in self.values)}"


def clipped(values: Array, beside: Array | None = None) -> Clipped | None:
    """Samples of a channel (n,) that are clipped at either end of its range; None where none are.

    A flat plateau of a noiseless loop also repeats one value. Clipping is reported only if the channel, or the channel
    `beside` (n,) recorded with it, scatters elsewhere.
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
    if same.all():
        return same.size
    turned = np.roll(same, -int(np.argmin(same)))
    edges = np.flatnonzero(np.diff(np.concatenate([[False], turned, [False]]).astype(int)))
    return int(np.max(edges[1::2] - edges[::2], initial=0))


def _scatters(values: Array, left_out: BoolArray, extent: float) -> bool:
    """True if samples alternate about the course of their neighbours, as noise does."""
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
