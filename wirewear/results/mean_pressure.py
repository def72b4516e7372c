"""Means of a contact's pressure over a length: at a crest as narrow as an element, pressures at nodes tell the mesh.

Each node's force is weighed by a normal distribution about a place, whose standard deviation is half the given length;
a mean over a disc of that radius has the same variance. Such means stay as they are when the mesh is refined.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from wirewear.errors import ResultError
from wirewear.results.checks import FloatArray


def largest_mean_pressure_MPa(places_um: ArrayLike, normal_force: ArrayLike, over_um: float) -> float:
    """The largest mean pressure over a length about any node, at any position of the cycle.

    places_um: (m,) nodes along the stroke of a line contact, or (m, 2) nodes on a wire's surface.  normal_force: (k, m)
    on them at k positions, of either sign: N/mm of a line contact, N of wires.

    Raises:
        ResultError: the length is not positive, or places and forces do not fit together.
    """
    places, forces = np.asarray(places_um, dtype=float), np.asarray(normal_force, dtype=float)
    if not over_um > 0.0:
        raise ResultError(f"a mean pressure is over a positive length, not over {over_um:g} µm")
    if places.ndim not in {1, 2} or forces.ndim != 2 or forces.shape[1] != places.shape[0] or forces.size == 0:
        raise ResultError(f"forces of shape {forces.shape} are not those on nodes at places of shape {places.shape}")
    places = 1e-3 * places.reshape(places.shape[0], -1)
    variance = (0.5e-3 * over_um) ** 2
    apart: FloatArray = ((places[:, None, :] - places) ** 2).sum(axis=2)
    weights = np.exp(-0.5 * apart / variance) / (2.0 * np.pi * variance) ** (0.5 * places.shape[1])
    return float((np.abs(forces) @ weights).max())
