"""Tractions of nodes whose direction of friction is known, as their normal tractions and the friction law give them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solvers.compiled import compiled
from solvers.newton.terms import FrictionTerms, Nodes

Array = NDArray[np.float64]


class Carried(NamedTuple):
    """World tractions of k nodes: `per_normal` (k, 3) times the normal one, plus `constant` (k, 3).

    shifted: whether any constant is not zero.
    """

    per_normal: Array
    constant: Array
    shifted: bool


@compiled
def carried_by(nodes: Nodes, friction: FrictionTerms) -> Carried:
    """What nodes carry whose friction follows its direction, by the law's tangent; others their normal traction."""
    frames, direction = nodes.frames, friction.direction
    per_normal, constant = np.empty((len(frames), 3)), np.zeros((len(frames), 3))
    shifted = False
    for k in range(len(frames)):
        for c in range(3):
            per_normal[k, c] = frames[k, 0, c]
            if friction.follows[k]:
                along = direction[k, 0] * frames[k, 1, c] + direction[k, 1] * frames[k, 2, c]
                per_normal[k, c] += friction.slope[k] * along
                constant[k, c] = friction.offset[k] * along
                shifted |= constant[k, c] != 0.0
    return Carried(per_normal, constant, shifted)
