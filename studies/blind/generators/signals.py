"""A loop's channels, and what amplifiers, stages, guides and loading trains may make of them."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Transfer = Callable[[Array], NDArray[np.complex128]]

#: Spacings of samples that differ by less than this share are even; uneven ones are filtered on a grid so much finer.
EVEN, FINER = 1e-6, 8


@dataclass(frozen=True, eq=False)
class Signals:
    """A cycle's channels (n,), periodic, from mid-stroke: times within the cycle, displacement, both forces."""

    time_s: Array
    period_s: float
    displacement_um: Array
    tangential_force_N: Array
    normal_force_N: Array


class Instrument(Protocol):
    """Anything that makes other channels of those it is given."""

    def read(self, signals: Signals, cycle: float) -> Signals:
        """The channels as changed at a cycle."""
        ...


def read_by(instruments: tuple[Instrument, ...], signals: Signals, cycle: float) -> Signals:
    """The channels after all instruments, one behind the other."""
    for instrument in instruments:
        signals = instrument.read(signals, cycle)
    return signals


def after_play(periodic: Array, play: float) -> Array:
    """What follows a periodic channel (n,) with a play: it moves once half of it is taken up, in either direction."""
    followed, at = np.empty_like(periodic), float(periodic[0])
    for _ in range(2):  # The second cycle repeats itself.
        for i, value in enumerate(periodic.tolist()):
            at = min(max(at, value - 0.5 * play), value + 0.5 * play)
            followed[i] = at
    return followed


def turned(displacement: Array, over: float) -> Array:
    """Direction of motion (n,), from −1 to 1: after a reversal it changes evenly over a travel `over` (> 0), in the
    unit of the displacement (n,).
    """
    return np.asarray((displacement - after_play(displacement, over)) / (0.5 * over))


def bent(displacement: Array, amplitude: float, bend: float) -> Array:
    """What a bent sensor adds to a displacement (n,): nothing at both ends and in the middle of ±amplitude."""
    place = displacement / amplitude
    return np.asarray(bend * amplitude * (place**3 - place))


def place_in_stroke(signals: Signals) -> tuple[Array, float]:
    """Place within the stroke, from −1 to 1 (n,), and half of the stroke [µm]."""
    read = signals.displacement_um
    middle, half = 0.5 * float(read.max() + read.min()), 0.5 * float(np.ptp(read))
    return np.asarray((read - middle) / half), half


def beyond(place: Array, side: float, begins: float) -> Array:
    """How far a place has come from `begins` to the end on a side's sign, 0 to 1 (n,)."""
    return np.asarray(np.maximum(np.sign(side) * place - begins, 0.0) / (1.0 - begins))


def loaded(signals: Signals, factor: Array) -> Signals:
    """Both forces times a factor (n,), as under another load."""
    return replace(
        signals, tangential_force_N=signals.tangential_force_N * factor, normal_force_N=signals.normal_force_N * factor
    )


def filtered(signals: Signals, values: Array, passed: Transfer) -> Array:
    """A periodic channel (n,) through a linear filter; uneven samples are joined by straight lines."""
    count, period = values.size, signals.period_s
    if np.ptp(np.diff(signals.time_s)) < EVEN * period / count:
        return _on_even_grid(values, period, passed)
    even = np.arange(FINER * count) * (period / (FINER * count))
    fine = np.interp(even, signals.time_s, values, period=period)
    return np.asarray(np.interp(signals.time_s, even, _on_even_grid(fine, period, passed), period=period))


def _on_even_grid(values: Array, period_s: float, passed: Transfer) -> Array:
    frequency = np.asarray(np.fft.rfftfreq(values.size, period_s / values.size))
    return np.asarray(np.fft.irfft(passed(frequency) * np.fft.rfft(values), values.size))
