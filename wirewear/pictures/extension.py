"""A field on a grid carried on beyond the area where it is known, as smoothly as it can be: a thin plate's deflection.

The values outside make the plate's bending energy least, the integral of f_xx² + 2 f_xy² + f_yy² (J. Duchon, 1977), in
differences on the grid.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.ndimage import binary_dilation
from scipy.sparse.linalg import spsolve

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Rings of points around the area that get a value.
RINGS = 2

#: What keeps points determined that no difference reaches, as a share of the largest weight.
_RIDGE = 1e-10


def extended(first: Array, second: Array, values: Array, inside: Mask) -> Array:
    """The values (n_1, n_2) with those of RINGS rings of points around `inside` replaced; first, second: grid lines."""
    band = binary_dilation(inside, np.ones((3, 3), dtype=bool), iterations=RINGS) & ~inside
    if not inside.any() or not band.any():
        return values
    rows = sparse.vstack([_bending(first, second, inside | band, axis) for axis in (0, 1)]
                         + [_twist(first, second, inside | band)]).tocsc()  # fmt: skip
    free, known = np.flatnonzero(band), np.flatnonzero(inside)
    plate = rows[:, free]
    normal = (plate.T @ plate).tocsc()
    normal += _RIDGE * normal.diagonal().max() * sparse.eye_array(free.size, format="csc")
    whole = values.copy()
    whole.ravel()[free] = spsolve(normal, -plate.T @ (rows[:, known] @ values.ravel()[known]))
    return whole


def _bending(first: Array, second: Array, known: Mask, axis: int) -> sparse.coo_array:
    """Second differences along an axis wherever all three points are known."""
    line, along = (first, known) if axis == 0 else (second, known.T)
    index = np.arange(known.size).reshape(known.shape)
    index = index if axis == 0 else index.T
    before, after = np.diff(line)[:-1], np.diff(line)[1:]
    place, other = np.nonzero(along[:-2] & along[1:-1] & along[2:])
    low, high = 2.0 / (before * (before + after)), 2.0 / (after * (before + after))
    return _rows(
        [index[place + step, other] for step in (0, 1, 2)], [low[place], -(low + high)[place], high[place]], known.size
    )


def _twist(first: Array, second: Array, known: Mask) -> sparse.coo_array:
    """Mixed differences over the cells whose corners are all known, weighted as the energy counts them."""
    index = np.arange(known.size).reshape(known.shape)
    i, j = np.nonzero(known[:-1, :-1] & known[1:, :-1] & known[:-1, 1:] & known[1:, 1:])
    weight = 2.0**0.5 / (np.diff(first)[i] * np.diff(second)[j])
    corners = [index[i, j], index[i + 1, j], index[i, j + 1], index[i + 1, j + 1]]
    return _rows(corners, [weight, -weight, -weight, weight], known.size)


def _rows(points: list[NDArray[np.int_]], weights: list[Array], size: int) -> sparse.coo_array:
    count = points[0].size
    place = np.tile(np.arange(count), len(points))
    return sparse.coo_array((np.concatenate(weights), (place, np.concatenate(points))), shape=(count, size))
