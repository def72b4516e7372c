"""Tractions of nodes whose direction of friction is known, as their normal tractions and the friction law give them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solvers.compiled import compiled
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
        frames = conditions.system.pairing.frames
        along = _along(frames, direction)
        constant = np.where(follows, offset, 0.0)[:, None] * along if offset.any() else None
        return cls(follows, slope, offset, _per_normal(frames, along, slope, follows), constant)


@compiled
def _along(frames: Array, direction: Array) -> Array:
    """Directions (k, 2) in the tangents of frames (k, 3, 3) as vectors (k, 3)."""
    along = np.empty((len(frames), 3))
    for k in range(len(frames)):
        for c in range(3):
            along[k, c] = direction[k, 0] * frames[k, 1, c] + direction[k, 1] * frames[k, 2, c]
    return along


@compiled
def _per_normal(frames: Array, along: Array, slope: Array, follows: BoolArray) -> Array:
    result = np.empty((len(frames), 3))
    for k in range(len(frames)):
        friction = slope[k] if follows[k] else 0.0
        for c in range(3):
            result[k, c] = frames[k, 0, c] + friction * along[k, c]
    return result
