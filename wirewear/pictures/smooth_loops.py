"""Loops as smooth closed curves through their samples, and which of many loops are shown."""

from collections.abc import Sequence

import numpy as np

from wirewear.results import Loop
from wirewear.results.checks import FloatArray

MOST_LOOPS = 6

#: Points along a smooth loop, beside its samples; loops of fewer samples are drawn as they are.
POINTS, CLOSED_FROM = 400, 5


def chosen_cycles(logged: Sequence[int], most: int = MOST_LOOPS) -> tuple[int, ...]:
    """At most `most` of the logged cycles: the last, and the first and the decades before it, evenly thinned."""
    cycles = sorted(set(logged))
    decades = [c for c in cycles if 10 ** round(np.log10(max(c, 1))) == c]
    wanted = cycles if len(cycles) <= most else sorted({cycles[0], *decades, cycles[-1]})
    places = np.unique(np.linspace(0, len(wanted) - 1, min(most, len(wanted))).round().astype(int))
    return tuple(wanted[place] for place in places)


def smooth_loop(loop: Loop, points: int = POINTS) -> tuple[FloatArray, FloatArray]:
    """Displacement [µm] and force [N] of the closed loop through all of its samples, see `smooth_curve`."""
    return smooth_curve(loop.displacement_um, loop.tangential_force_N, points)


def smooth_curve(displacement_um: FloatArray, force: FloatArray, points: int = POINTS) -> tuple[FloatArray, FloatArray]:
    """A closed loop through all of its samples (n,), with at least `points` points of each coordinate.

    Monotone cubics over the length along the loop; nothing is drawn beyond neighbouring samples.
    """
    x, q = (np.append(values, values[0]) for values in (displacement_um, force))
    from scipy.interpolate import PchipInterpolator

    lengths = np.hypot(*(np.diff(values) / (np.ptp(values) or 1.0) for values in (x, q)))
    passed = np.concatenate([[True], lengths > 0.0])
    if passed.sum() < CLOSED_FROM:
        return x, q
    x, q, lengths = x[passed], q[passed], lengths[lengths > 0.0]
    at = np.concatenate([[0.0], np.cumsum(lengths)])
    around = np.concatenate([at[-4:-1] - at[-1], at, at[-1] + at[1:4]])
    fine = np.unique(np.concatenate([np.linspace(0.0, at[-1], points), at]))
    curves = (PchipInterpolator(around, np.concatenate([v[-4:-1], v, v[1:4]]))(fine) for v in (x, q))
    one, other = curves
    one[-1], other[-1] = one[0], other[0]
    return one, other
