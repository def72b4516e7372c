"""Lag of a periodic signal: a pure delay, or a first-order low-pass filter."""

from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from wirewear.errors import SensorError
from wirewear.sensor.signals import Array, LoopSignals

LagKind = Literal["first-order", "delay"]

#: Factors (n,) of the oscillations of given frequencies in Hz.
Transfer = Callable[[Array], NDArray[np.complex128]]

#: A filter that lets less than this share of the fastest oscillation through cannot be undone.
LEAST_PASSED = 0.01

# Uneven samples are carried over to an even grid this many times as fine.
_REFINEMENT = 4


def lagged(signals: LoopSignals, values: Array, time_s: float, kind: LagKind) -> Array:
    """The periodic channel `values` (n,) of a loop behind a lag.

    A delay gives x(t − τ), a first-order lag the periodic solution of τ y' + y = x, both as products of the Fourier
    series with exp(−iωτ) and 1/(1 + iωτ) (e.g. Bendat & Piersol, Random Data, 4th ed., section 2.3).

    Raises:
        SensorError: values that are not finite, or times without a period.
    """
    return _filtered(signals, values, lambda frequency: _transfer(frequency, time_s, kind))


def advanced(signals: LoopSignals, values: Array, time_s: float, kind: LagKind) -> Array:
    """What `lagged` had been given, to round-off where the samples are evenly spread.

    Raises:
        SensorError: as `lagged`, or a filter so slow that undoing it would raise the noise a hundredfold.
    """

    def inverse(frequency: Array) -> NDArray[np.complex128]:
        transfer = _transfer(frequency, time_s, kind)
        if np.abs(transfer).min() < LEAST_PASSED:
            raise SensorError(
                f"a first-order lag of {time_s:g} s cannot be undone on samples {1.0 / (2.0 * frequency[-1]):.3g} s "
                f"apart: it lets less than {LEAST_PASSED:.0%} of the fastest oscillation through"
            )
        return np.asarray(1.0 / transfer)

    return _filtered(signals, values, inverse)


def _transfer(frequency: Array, time_s: float, kind: LagKind) -> NDArray[np.complex128]:
    angle = 2.0 * np.pi * frequency * time_s
    return np.asarray(np.exp(-1j * angle) if kind == "delay" else 1.0 / (1.0 + 1j * angle))


def _filtered(signals: LoopSignals, values: Array, transfer: Transfer) -> Array:
    if not np.isfinite(values).all():
        raise SensorError("a lag needs a loop without missing samples")
    spacing = signals.spacing_s
    period = float(spacing.sum())
    if signals.evenly_spread:
        return _on_even_grid(values, period, transfer)
    time = signals.time_s - signals.time_s[0]
    even = np.arange(_REFINEMENT * values.size, dtype=np.float64) * (period / (_REFINEMENT * values.size))
    filtered = _on_even_grid(_interpolated(time, values, period, even), period, transfer)
    return _interpolated(even, filtered, period, time)


def _on_even_grid(values: Array, period_s: float, transfer: Transfer) -> Array:
    n = values.size
    factors = transfer(np.asarray(np.fft.rfftfreq(n, period_s / n), dtype=np.float64))
    if n % 2 == 0:
        # The fastest oscillation on the grid has no phase of its own; its size alone can change, and back.
        factors[-1] = np.abs(factors[-1])
    return np.asarray(np.fft.irfft(factors * np.fft.rfft(values), n), dtype=np.float64)


def _interpolated(time: Array, values: Array, period_s: float, at: Array) -> Array:
    """Periodic values (n,) by a cubic spline at other times."""
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(np.append(time, period_s), np.append(values, values[0]), bc_type="periodic")
    return np.asarray(spline(at), dtype=np.float64)
