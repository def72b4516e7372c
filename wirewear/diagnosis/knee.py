"""Force just past the knee, where sliding begins, over that further along: a peak there is no slope of the scar."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: The knee is where the share of the rise leads the travel, in this many amplitudes, the most.
_TRAVEL, _EARLY = 1.6, 1.4

#: Windows of travel past the knee in amplitudes: where a peak stands, and beyond it.
PEAK, BEYOND = (0.015, 0.12), (0.2, 0.4)


def knee_index(travel_um: Array, force_N: Array, top_N: float, amplitude_um: float) -> int:
    """Place of the knee on a branch (m,) that rises with its travel, `top_N` being the force at mid-stroke."""
    low = float(np.min(force_N[: max(3, force_N.size // 6)]))
    rise = (force_N - low) / max(top_N - low, 1e-12) - travel_um / (_TRAVEL * amplitude_um)
    return max(int(np.argmax(np.where(travel_um < _EARLY * amplitude_um, rise, -np.inf))), 1)


def peak_N(past_um: Array, force_N: Array, amplitude_um: float) -> tuple[float, float]:
    """Mean force of a branch (m,) in the window of the peak less that beyond, and the factor from noise to its error.

    `past_um` is measured from the knee. NaN where a window holds too few samples.
    """
    near, far = ((past_um >= low * amplitude_um) & (past_um <= high * amplitude_um) for low, high in (PEAK, BEYOND))
    counts = int(near.sum()), int(far.sum())
    if counts[0] < 2 or counts[1] < 3:
        return np.nan, np.nan
    return float(force_N[near].mean() - force_N[far].mean()), float(np.sqrt(1.0 / counts[0] + 1.0 / counts[1]))


def computed_peaks_N(displacement_um: Array, force_N: Array) -> Array:
    """The same of computed branches (n, 2, m), both in order of travel, (n, 2)."""
    peaks = np.empty(displacement_um.shape[:2])
    past = np.concatenate([np.linspace(*PEAK, 6), np.linspace(*BEYOND, 6)])
    for row, (xs, qs) in enumerate(zip(displacement_um, force_N, strict=True)):
        for side, sign in enumerate((1.0, -1.0)):
            x, q = sign * xs[side], sign * qs[side]
            amplitude = 0.5 * float(x[-1] - x[0])
            middle = float(np.interp(0.5 * (x[0] + x[-1]), x, q))
            knee = knee_index(x - x[0], q, middle, amplitude)
            at = np.interp(x[knee] + past * amplitude, x, q)
            peaks[row, side] = at[:6].mean() - at[6:].mean()
    return peaks
