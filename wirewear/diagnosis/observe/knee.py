"""Force just past the knee, where sliding begins, over that further along: a peak there is no slope of the scar."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.readings import still_to_come
from wirewear.diagnosis.observe.noise_of_samples import noise_factor

Array = NDArray[np.float64]

_KNOWN = constants("observe.knee")

#: The knee is where the share of the rise leads the travel, in this many amplitudes, the most.
_TRAVEL, _EARLY = _KNOWN.each("travel", "early")

#: Windows of travel past the knee in amplitudes: where a peak stands, and beyond it.
PEAK, BEYOND = _KNOWN.pair("peak"), _KNOWN.pair("beyond")


def knee_index(travel_um: Array, force_N: Array, top_N: float, amplitude_um: float, reversal_N: float = np.inf) -> int:
    """Place of the knee on a branch (m,) that rises with its travel, `top_N` being the force at mid-stroke.

    reversal_N: force where the other branch ends: a drive that turns sharply has risen far by the first sample.
    """
    return int(_knees(travel_um, force_N, np.array([top_N]), np.array([amplitude_um]), reversal_N))


def _knees(
    travel_um: Array, force_N: Array, top_N: Array, amplitude_um: Array, reversal_N: float = np.inf
) -> NDArray[np.intp]:
    """Places (...) of the knees of branches (..., m), of forces at mid-stroke and amplitudes (..., 1)."""
    low = force_N[..., : max(3, force_N.shape[-1] // 6)].min(axis=-1, keepdims=True)
    low = np.minimum(low, reversal_N)
    rise = (force_N - low) / np.maximum(top_N - low, 1e-12) - travel_um / (_TRAVEL * amplitude_um)
    knees: NDArray[np.intp] = np.argmax(np.where(travel_um < _EARLY * amplitude_um, rise, -np.inf), axis=-1)
    return np.maximum(knees, 1)


def peak_N(past_um: Array, force_N: Array, amplitude_um: float, correlation: float = 0.0) -> tuple[float, float]:
    """Mean force of a branch (m,) in the window of the peak less that beyond, and the factor from noise to its error.

    `past_um` is measured from the knee. NaN where a window holds too few samples.
    """
    near, far = ((past_um >= low * amplitude_um) & (past_um <= high * amplitude_um) for low, high in (PEAK, BEYOND))
    counts = int(near.sum()), int(far.sum())
    if counts[0] < 2 or counts[1] < 3:
        return np.nan, np.nan
    weights = near / counts[0] - far / counts[1]
    used = np.flatnonzero(weights)
    return float(weights @ force_N), noise_factor(weights[used], used, correlation)


def computed_peaks_N(displacement_um: Array, force_N: Array) -> Array:
    """The same of computed branches (n, 2, m), both in order of travel, (n, 2)."""
    sign = np.array([1.0, -1.0])[:, None]
    x, q = sign * displacement_um, sign * force_N
    travel = x - x[..., :1]
    amplitude = 0.5 * travel[..., -1:]
    passed = still_to_come(travel)
    knee = _knees(travel, q, _read(passed, q, amplitude), amplitude)
    from_knee = np.take_along_axis(travel, knee[..., None], axis=-1)
    past = np.concatenate([np.linspace(*PEAK, 6), np.linspace(*BEYOND, 6)])
    at = _read(passed, q, from_knee + amplitude * past)
    peaks: Array = at[..., :6].mean(axis=-1) - at[..., 6:].mean(axis=-1)
    return peaks


def _read(travel: Array, force: Array, at: Array) -> Array:
    """Forces (..., k) at travels, linear between the points (..., m) of each branch."""
    right = np.clip((travel[..., None, :] < at[..., None]).sum(axis=-1), 1, travel.shape[-1] - 1)
    start, first, end, last = (
        np.take_along_axis(values, side, axis=-1) for side in (right - 1, right) for values in (travel, force)
    )
    share = np.clip((at - start) / np.maximum(end - start, 1e-12), 0.0, 1.0)
    return np.asarray(first + share * (last - first))
