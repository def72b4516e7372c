"""Pressures away from the rim of a contact.

A node at the rim carries the load of an area that may end anywhere between it and the next one: on its own area that
comes to up to twice the pressure about it, however fine the mesh. The mean over an element that reaches beyond the rim
has no such excess, and forces add up the same.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from solvers.compiled import compiled

Array = NDArray[np.float64]


def largest_within(pressure: Array) -> float:
    """The largest pressure inside a contact, from nodal pressures (n_a, n_t) on the lines of a patch, 0 out of contact.

    Of nodes whose neighbours all touch their own pressure counts, of all others the means over elements. A patch of one
    line has neighbours along it only.
    """
    return float(_largest_within(np.ascontiguousarray(pressure)))


@compiled
def _largest_within(pressure: Array) -> float:
    rows, columns = pressure.shape
    beside_a, beside_t = min(rows - 1, 1), min(columns - 1, 1)
    largest = 0.0
    for i in range(rows - beside_a):
        for j in range(columns - beside_t):
            here = 0.5 * (pressure[i + beside_a, j] + pressure[i, j])
            next_to = 0.5 * (pressure[i + beside_a, j + beside_t] + pressure[i, j + beside_t])
            largest = max(largest, 0.5 * (next_to + here))
    for i in range(beside_a, rows - beside_a):
        for j in range(beside_t, columns - beside_t):
            if pressure[i, j] > largest:
                all_touch = True
                for a in range(i - beside_a, i + beside_a + 1):
                    for t in range(j - beside_t, j + beside_t + 1):
                        all_touch &= pressure[a, t] > 0.0
                if all_touch:
                    largest = pressure[i, j]
    return largest
