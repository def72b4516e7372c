"""Tractions of nodes whose direction of friction is known, as their normal tractions and the friction law give them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solvers.newton.conditions import ContactConditions

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True)
class Carried:
    """World tractions of k nodes: `per_normal` (k, 3) times the normal one, plus `constant` (k, 3), None where zero.

    follows: (k,) nodes whose friction follows a known direction.  slope, offset: (k,) the friction law's tangent.
    """

    follows: BoolArray
    slope: Array
    offset: Array
    per_normal: Array
    constant: Array | None

    @classmethod
    def along(cls, conditions: ContactConditions, pressure: Array, direction: Array, follows: BoolArray) -> Carried:
        """What friction along `direction` (k, 2) adds where it is known, linearised about pressures (k,)."""
        slope, offset = conditions.system.friction.tangent(pressure)
        t1, t2 = conditions.tangents[:, 0, :], conditions.tangents[:, 1, :]
        along = direction[:, :1] * t1 + direction[:, 1:] * t2
        per_normal = conditions.normals + np.where(follows, slope, 0.0)[:, None] * along
        constant = np.where(follows, offset, 0.0)[:, None] * along if offset.any() else None
        return cls(follows, slope, offset, per_normal, constant)
