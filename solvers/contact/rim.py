"""Pressures away from the rim of a contact.

A node at the rim carries the load of an area that may end anywhere between it and the next one: on its own area that
comes to up to twice the pressure about it, however fine the mesh. The mean over an element that reaches beyond the rim
has no such excess, and forces add up the same.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def largest_within(pressure: Array) -> float:
    """The largest pressure inside a contact, from nodal pressures (n_a, n_t) on the lines of a patch, 0 out of contact.

    Of nodes whose neighbours all touch their own pressure counts, of all others the means over elements. A patch of one
    line has neighbours along it only.
    """
    touching = pressure > 0.0
    means, inside = pressure, touching
    for axis, count in enumerate(pressure.shape):
        if count == 1:
            continue
        means = 0.5 * (np.take(means, range(1, count), axis) + np.take(means, range(count - 1), axis))
        inside = inside & _both_beside(inside, axis)
    return float(max(means.max(initial=0.0), np.where(inside, pressure, 0.0).max(initial=0.0)))


def _both_beside(chosen: NDArray[np.bool_], axis: int) -> NDArray[np.bool_]:
    """Whether both neighbours along an axis are among the chosen."""
    beside = np.zeros_like(chosen)
    lines, within = np.moveaxis(chosen, axis, 0), np.moveaxis(beside, axis, 0)
    within[1:-1] = lines[2:] & lines[:-2]
    return beside
