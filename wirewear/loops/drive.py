"""Smooth course of a periodic signal (drive displacement, normal load) and its noise, drift and period.

A smooth signal is a short Fourier series, or three straight ramps, fitted to the samples of one cycle. A drift is a
constant rate at which the signal moves away while it cycles.
"""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array, BoolArray
from wirewear.loops.noise import sample_noise
from wirewear.loops.robust import LinearFit, best_fit, fit_linear, mean_misfits

HIGHEST_HARMONIC = 6

#: A drift within a cycle is one from this share of the stroke and so many of its deviations on; by a larger share the
#: cycle is cut short, as it is if its period is another one than the samples' by more than the last share.
LEAST_DRIFT, CERTAIN, MOST_DRIFT, WHOLE = 0.01, 5.0, 0.2, 0.02

#: By so much another period must leave smaller residuals to show that it is no drift that opens the cycle.
BETTER = 0.9

REFINED = 5  #: Newton's steps to that period, each of which leaves less than a tenth of its error.
WINDOWS, MOST_WINDOWS = 8, 2000  #: Beginnings in each cycle, and in all, of windows in which a phase is sought.


@dataclass(frozen=True)
class SmoothSignal:
    """Smooth course of n samples of a signal, in the samples' unit, with their noise."""

    values: Array  #: (n,) smooth signal, or the samples themselves where no smooth signal explains them.
    noise: float  #: Standard deviation of one sample.
    deviation: float  #: Standard deviation of one entry of values.
    outliers: BoolArray  #: (n,) True for samples farther than 5 `noise` from the smooth signal.
    smoothed: bool  #: False if `values` are the samples themselves.


def smooth_periodic(time: Array, values: Array, *, lowest_harmonic: int = 1) -> SmoothSignal:
    """Fit a smooth course to one cycle of a signal (n,): a Fourier series with a linear drift, or three straight ramps.

    time: (n,) of the samples, in any unit. Schwarz's criterion chooses the number of harmonics, from `lowest_harmonic`
    up; 0 lets the signal be constant. Where neither fit explains the samples to within their noise, where there is next
    to no noise, or where there are fewer than 40 samples, the samples are returned unchanged, with `smoothed` False.
    """
    count = len(values)
    noise = sample_noise(values, time)
    unchanged = rough(values, noise)
    extent = float(np.subtract(*np.percentile(values, [99, 1])))
    if noise <= 2e-4 * extent or count < 8 * (HIGHEST_HARMONIC - 1):
        return unchanged
    largest = (1.0 + 5.0 / np.sqrt(count)) * noise
    period = _period(time, values) if lowest_harmonic else even_period(time)
    designs = [series(time, period, harmonics) for harmonics in range(lowest_harmonic, HIGHEST_HARMONIC)]
    fit = fit_linear(designs[best_fit(designs, values)], values)
    if fit.scale > largest or len(fit.coefficients) > 4:
        # more than one harmonic may be a triangle in disguise, whose tips a short series rounds off
        fit = min(fit, _ramps(time, values), key=lambda candidate: candidate.scale)
    if fit.scale > largest:
        return unchanged
    deviation = fit.scale * float(np.sqrt(len(fit.coefficients) / count))
    outliers = np.abs(fit.residuals) > 5.0 * fit.scale
    return SmoothSignal(values - fit.residuals, fit.scale, deviation, outliers, smoothed=True)


def rough(values: Array, noise: float = 0.0) -> SmoothSignal:
    """Samples (n,) as a signal that is not smoothed; `noise` is the standard deviation of a sample."""
    return SmoothSignal(values, noise, noise, np.zeros(len(values), bool), smoothed=False)


@dataclass(frozen=True)
class Drift:
    """Rate at which a drive moves off while it cycles, in the displacement's unit per unit of time; 0 if it does not.

    certain: False if a slightly different period would explain the samples as well as the drift does.
    """

    rate: float = 0.0
    certain: bool = False


def drift_of(time: Array, values: Array) -> Drift:
    """Drift of a drive's samples (n,) over one cycle, from a short Fourier series with a linear term; a rate of 0 where
    none shows. time: (n,).

    A cycle cut short or overrun also ends away from its start; a second fit with free period distinguishes the two
    where the samples allow.
    """
    extent = float(np.ptp(values))
    if len(values) < 8 * (HIGHEST_HARMONIC - 1):
        return Drift()
    even = even_period(time)
    whole = fit_linear(series(time, even, 2), values)
    opening = 2.0 * float(whole.coefficients[1])
    if not LEAST_DRIFT * extent < abs(opening) < MOST_DRIFT * extent:
        return Drift()
    period = _period(time, values)
    columns = series(time, period, 2)
    free = fit_linear(columns, values)
    # What another period would change: the two are distinguished only as far as this column is none of the others.
    stretched = (time - float(time.mean())) * np.gradient(values - free.residuals, time)
    fit = fit_linear(np.column_stack([columns, stretched]), values)
    total, deviation = 2.0 * float(fit.coefficients[1]), 2.0 * float(np.sqrt(fit.covariance[1, 1]))
    # A drift opens the cycle by itself; more of it, or less, is what no short series fits.
    open_by = 2.0 * float(values[-1]) - float(values[-2]) - float(values[0])
    alike = abs(total - open_by) < max(0.3 * abs(open_by), 4.0 * fit.scale)
    if alike and abs(period / even - 1.0) < WHOLE and abs(total) > max(CERTAIN * deviation, 5.0 * fit.scale):
        return Drift(total / period, certain=True)
    # Steps that are not alike leave open when the cycle closes.
    return Drift(opening / even) if free.scale > BETTER * whole.scale and not uneven(time) else Drift()


def uneven(time: Array) -> BoolArray:
    """(...) True for each loop of times (..., n) whose sampling steps are uneven: their upper quartile exceeds 1.5
    times the lower one.
    """
    low, high = np.percentile(np.diff(time), [25, 75], axis=-1)
    # Steps of time are alike whose upper quartile exceeds the lower one by no more than this factor.
    return np.asarray(high > 1.5 * low)


def period_of(time: Array, displacement: Array) -> float:
    """Duration of the cycle that samples (n,) at times (n,) cover, in the unit of `time`; the last sample does not
    repeat the first.

    Samples count as spread evenly over the cycle, unless a sine of another period leaves residuals smaller by a tenth.
    """

    def sine(period: float) -> tuple[float, float]:
        phase = 2.0 * np.pi * (time - time[0]) / period
        wave = np.exp(1j * phase)
        design = np.column_stack([np.ones_like(phase), wave.real, wave.imag])
        fit = np.linalg.lstsq(design, displacement, rcond=None)[0]
        design = np.column_stack([design, phase * (fit[2] * wave.real - fit[1] * wave.imag)])
        sooner = np.linalg.lstsq(design, displacement, rcond=None)[0][3]
        return float(np.std(displacement - design[:, :3] @ fit)), float(period / (1.0 + np.clip(sooner, -0.5, 1.0)))

    even = period = even_period(time)
    for _ in range(REFINED):
        period = sine(period)[1]
    return period if sine(period)[0] < BETTER * sine(even)[0] else even


def period_by_phase(time: Array, displacement: Array, about: float) -> float:
    """Period, in the unit of `time`, of samples (n,) that span more than two cycles without gaps, from the phase of
    their fundamental over time; ripples on the drive hardly move it, unlike the sample at which a cycle begins.

    about: first estimate of the period, good enough to count the cycles.
    """
    period = about
    for _ in range(REFINED):
        length = 2.0 * period
        count = int(np.clip(WINDOWS * ((time[-1] - time[0] - length) / period), 2, MOST_WINDOWS))
        begins = np.linspace(time[0], time[-1] - length, count)
        found = []
        for begin, end in zip(begins, begins + length, strict=True):
            part = slice(*np.searchsorted(time, (begin, end)))
            # Under Hann's window of two cycles no harmonic is another's, and ripples between them leave little.
            weight = np.sin(np.pi * (time[part] - begin) / length)
            wave = np.exp(2j * np.pi * (time[part] - time[0]) / period)
            columns = np.column_stack([wave.real, wave.imag, np.ones_like(weight)])
            fit = np.linalg.lstsq(weight[:, None] * columns, weight * displacement[part], rcond=None)[0]
            found.append(complex(fit[0], -fit[1]))
        ahead = np.polyfit(begins, np.unwrap(np.angle(found)), 1, w=np.abs(found))[0] / (2.0 * np.pi)
        period = float(1.0 / (1.0 / period + ahead))
    return period


def even_period(time: Array) -> float:
    """Period, in the unit of `time` (n,), of samples evenly spread over one cycle that does not repeat the first."""
    count = len(time)
    return float(time[-1] - time[0]) * count / (count - 1)


def series(time: Array, period: float, harmonics: int) -> Array:
    """Columns (n, 2 + 2 k) of a Fourier series with k harmonics at times (n,): a constant, a line from -1 to 1 over the
    period, then cosine and sine of each harmonic.
    """
    phase = 2.0 * np.pi * (time - time[0]) / period
    columns = [np.ones_like(phase), phase / np.pi - 1.0]
    for k in range(1, harmonics + 1):
        columns += [np.cos(k * phase), np.sin(k * phase)]
    return np.column_stack(columns)


def _period(time: Array, values: Array) -> float:
    """Period whose Fourier series leaves the smallest residual, within 12 % of that of evenly spread samples."""
    middle = even_period(time)
    factors = np.linspace(0.88, 1.12, 11)

    def misfits() -> Array:
        return mean_misfits([series(time, middle * float(factor), 2) for factor in factors], values)

    for count in (7, 7):
        best = int(np.clip(np.argmin(misfits()), 1, len(factors) - 2))
        factors = np.linspace(factors[best - 1], factors[best + 1], count)
    return middle * float(factors[int(np.argmin(misfits()))])


def _ramps(time: Array, values: Array) -> LinearFit:
    """Fit of three connected straight lines, whose two corners are sought around the two extremes."""
    corners = sorted([float(time[np.argmax(values)]), float(time[np.argmin(values)])])
    span = float(time[-1] - time[0])

    def design(first: float, second: float) -> Array:
        columns = [np.ones_like(time), time - time[0], np.maximum(time - first, 0.0), np.maximum(time - second, 0.0)]
        return np.column_stack(columns)

    reach = 0.04 * span
    while reach > 1e-4 * span:
        for which in (0, 1):
            trials = [list(corners) for _ in range(7)]
            for moved, shift in zip(trials, np.linspace(-reach, reach, 7), strict=True):
                moved[which] += float(shift)
            corners = trials[int(np.argmin(mean_misfits([design(*moved) for moved in trials], values)))]
        reach *= 0.4
    return fit_linear(design(*corners), values)
