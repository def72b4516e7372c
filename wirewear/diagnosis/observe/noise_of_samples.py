"""What the samples of a measured loop say of their noise: its size, and how far neighbours go along with each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.setup import Array
from wirewear.loops.cleaning import CleanLoop
from wirewear.loops.correlated_noise import correlated_noise
from wirewear.records.tables import Noise

_OF_NOISE_OF_SUMS = constants("observe.noise_of_sums")

#: Neighbours that are more alike than this are a drift, not noise.
MOST_CORRELATED = _OF_NOISE_OF_SUMS.number("most_correlated")

_KNOWN = constants("observe.noise_of_samples")

#: Least and largest degree of the curve through a sliding branch about which its noise is taken, and samples for each:
#: the walls of a deep scar bend a branch sharply near its ends.
SMOOTH_DEGREES = tuple(int(degree) for degree in _KNOWN.numbers("smooth_degrees"))
SAMPLES_A_DEGREE = _KNOWN.count("samples_a_degree")

#: Harmonics of a drive about which the noise of few displacements is taken.
DRIVE_HARMONICS = _KNOWN.count("drive_harmonics")

#: Deviations at which samples are clipped where noise is told from shape: on a branch, and of the normal force.
CLIPPED, NORMAL_OUTLYING = _KNOWN.each("clipped", "normal_outlying")


def noise_factor(weights: Array, order: NDArray[np.intp], correlation: float) -> float:
    """From a sample's noise to that of a sum with weights (m,), of samples with these numbers (m,) on their branch.

    Their noise is an autoregression of first order with that correlation of neighbours: few samples in a row average
    less of it away than many, but have not yet the error of a mean of many such samples.
    """
    if correlation <= 0.0:
        return float(np.linalg.norm(weights))
    return float(np.sqrt(noise_product(weights, order, weights, order, correlation)))


def noise_product(
    weights: Array, order: NDArray[np.intp], others: Array, their_order: NDArray[np.intp], correlation: float
) -> float:
    """Covariance of two sums over samples of one branch, (m,) and (k,), over a sample's variance, like that."""
    apart = np.abs(order[:, None] - their_order)
    return float(weights @ np.where(apart == 0, 1.0, max(correlation, 0.0) ** apart) @ others)


def correlation_of(stretch: float) -> float:
    """Correlation of neighbours whose noise makes means of many samples that much less certain."""
    return (stretch**2 - 1.0) / (stretch**2 + 1.0)


def correlation_of_neighbours(factor: float) -> float:
    """The correlation of which `noise_of_neighbours` is that factor; 0 for one of at most 1."""
    if factor <= noise_of_neighbours(0.0):
        return 0.0
    most = noise_of_neighbours(MOST_CORRELATED)
    if factor >= most:
        return MOST_CORRELATED
    return float(brentq(lambda correlation: noise_of_neighbours(correlation) - factor, 0.0, MOST_CORRELATED))


def stretch_of(correlation: float) -> float:
    """By what neighbours of that correlation make means of many samples less certain."""
    return float(np.sqrt((1.0 + correlation) / (1.0 - correlation)))


def noise_of_neighbours(correlation: float) -> float:
    """Factor from a noise that was told as uncorrelated, by cubics through four neighbours, to that of a sample.

    Correlated neighbours go along with a sample, so that its distance to their cubic is smaller.
    """
    numbers = np.array([0, -2, -1, 1, 2])
    weights = np.array([1.0, 1.0 / 6.0, -2.0 / 3.0, -2.0 / 3.0, 1.0 / 6.0])
    return float(np.linalg.norm(weights)) / noise_factor(weights, numbers, correlation)


def noise_of_samples(
    sliding: Sequence[tuple[Array, Array]],
    normal_N: Sequence[Array],
    clean: CleanLoop,
    raw: CleanLoop,
    time_s: Array,
    stated: Noise,
    rounding_N: float = 0.0,
) -> tuple[float, float, float | None]:
    """Standard deviation of one sample's force [N], what correlation makes of means, and the normal force's deviation.

    `sliding` are displacements and forces of the branches past their knees, `normal_N` the normal forces there. `raw`
    is the loop without its smooth drive. Where shape hides the noise of few samples, the normal force tells how
    neighbours correlate, or the displacement about a smooth drive; or else how near they lie to each other, beside the
    noise that is stated. The last is None where the normal force was not asked. `rounding_N` is what steps of the force
    add to a sample's noise.
    """
    if (known := _force_noise(sliding, stated, rounding_N)) is not None:
        return *known, None
    other = _noise_of_another(normal_N, clean, time_s, stated)
    stretch = other[1] if other else _stated_stretch(stated, raw)
    return _stated_noise(stated, clean), stretch, other[0] if other else None


def noise_of_displacement(neighbours_um: float, stretch: float, rounding_um: float) -> float:
    """Standard deviation of one displacement from that told of its neighbours; rounding is like none of them."""
    under = float(np.sqrt(max(neighbours_um**2 - rounding_um**2, 0.0)))
    return float(np.hypot(under * noise_of_neighbours(correlation_of(stretch)), rounding_um))


def usual(values: Array) -> tuple[float, float]:
    """Median of values, and their spread by the median distance from it."""
    centre = float(np.median(values))
    return centre, 1.4826 * float(np.median(np.abs(values - centre))) + 1e-12


def _force_noise(
    sliding: Sequence[tuple[Array, Array]], stated: Noise, rounding_N: float
) -> tuple[float, float] | None:
    """Standard deviation of a sliding branch's force about a smooth curve, and what correlation makes of means.

    None where there are too few samples to tell noise from shape.
    """
    parts: list[tuple[Array, Array]] = []
    for x, q in sliding:
        degree = min(x.size // SAMPLES_A_DEGREE, SMOOTH_DEGREES[1])
        if degree < SMOOTH_DEGREES[0]:
            return None
        place = 2.0 * (x - x.min()) / max(float(np.ptp(x)), 1e-12) - 1.0
        design = np.polynomial.chebyshev.chebvander(place, degree)
        rest = q - design @ np.linalg.lstsq(design, q, rcond=None)[0]
        spread = 1.4826 * float(np.median(np.abs(rest)))
        parts.append((design, np.clip(rest, -CLIPPED * spread, CLIPPED * spread)))
    return correlated_noise(parts, stated.tangential_force_N, rounding_N)


def _stated_stretch(stated: Noise, raw: CleanLoop) -> float:
    """What correlation makes of means, where neighbours lie nearer to each other than the stated noise of a sample."""
    if not stated.displacement_um or not raw.raw_noise_um:
        return 1.0
    return stretch_of(correlation_of_neighbours(stated.displacement_um / raw.raw_noise_um))


def _stated_noise(stated: Noise, clean: CleanLoop) -> float:
    """What the record says of a sample's noise, or how far neighbours of few samples lie apart."""
    known = stated.tangential_force_N
    return clean.force_noise_N if known is None else known


def _noise_of_another(
    normal_N: Sequence[Array], clean: CleanLoop, time_s: Array, stated: Noise
) -> tuple[float, float] | None:
    """As of `_force_noise`, where shape hides it in few samples: that of the normal force, which hardly changes.

    Without one the displacement tells how noise correlates, as far as a smooth drive explains it; None if none does.
    """
    parts: list[tuple[Array, Array]] = []
    for values in normal_N:
        centre, spread = usual(values)
        design = np.stack([np.ones(values.size), np.linspace(-1.0, 1.0, values.size)], axis=1)
        parts.append((design, np.clip(values, centre - NORMAL_OUTLYING * spread, centre + NORMAL_OUTLYING * spread)))
    if parts:
        return correlated_noise(parts, stated.normal_force_N)
    if not clean.smoothed:
        return None
    time = time_s[clean.index]
    phase = 2.0 * np.pi * (time - time[0]) / (time[-1] - time[0]) * (1.0 - 1.0 / time.size)
    harmonics = [wave(k * phase) for k in range(1, DRIVE_HARMONICS + 1) for wave in (np.cos, np.sin)]
    design = np.stack([np.ones(time.size), phase, *harmonics], axis=1)
    return correlated_noise([(design, clean.raw_displacement_um)], stated.displacement_um)
