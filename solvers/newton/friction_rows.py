"""Tangential equations of one Newton iteration: zero slip, or friction against it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from solvers.compiled import compiled
from solvers.newton.terms import FrictionTerms

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


@compiled
def fill_friction_rows(
    transposed: Array, rhs: Array, slips: Array, offsets: Array, friction: FrictionTerms, on: IntArray, tan: IntArray
) -> None:
    """Write the rows of the nodes near stick: zero slip, or the linearised projection onto the friction cone.

    slips, offsets: of these nodes, see `slip_rows`.  In absolute unknowns the projection reads
    q - tau(p) d - weight (1 - d d^T)(q - augmentation s) = 0, here times the slip per traction.
    """
    a, m = len(on), len(tan)
    column = np.full(len(friction.limit), -1)
    for i in range(a):
        column[on[i]] = i
    for i in range(m):
        node = tan[i]
        augmentation, direction = friction.augmentation[node], friction.direction[node]
        trial_0 = friction.tangential[node, 0] - augmentation * friction.slip[node, 0]
        trial_1 = friction.tangential[node, 1] - augmentation * friction.slip[node, 1]
        size = max(np.sqrt(trial_0**2 + trial_1**2), 1e-300)
        weight = min(friction.limit[node] / size, 1.0)
        for c in range(2):
            row = a + c * m + i
            if friction.stick[node]:
                for j in range(len(transposed)):
                    transposed[j, row] = slips[c * m + i, j]
                rhs[row] = -offsets[c * m + i]
                continue
            transposed[row, row] = 1.0 / augmentation
            transposed[column[node], row] = -friction.slope[node] * direction[c] / augmentation
            rhs[row] = friction.offset[node] * direction[c] / augmentation
            for e in range(2):
                factor = weight * ((1.0 if c == e else 0.0) - direction[c] * direction[e])
                transposed[a + e * m + i, row] -= factor / augmentation
                for j in range(len(transposed)):
                    transposed[j, row] += factor * slips[e * m + i, j]
                rhs[row] -= factor * offsets[e * m + i]
