"""Stresses in the surface of a half-space by the tractions around a point, which act between the nodes of a grid."""

import numpy as np

from geometry.arrays import Array, BoolArray
from solvers.jit_cache import compiled, inlined
from solvers.stress.subgrid_traction import bicubic_coefficients, polynomial

#: Tractions act on a point from so many mean elements away, along so many directions, at so many distances.
_REACH, _DIRECTIONS, _DISTANCES = 8.0, 32, 32
#: Places along each side of a cell at which its square is tried, and the share of its range by which it may be higher.
_SAMPLED, _ROOM = 4, 0.1


@compiled
def half_space_stress(places: Array, size: Array, square: Array, ratio: Array, rooted: bool, nu: float) -> Array:
    """Boussinesq's and Cerruti's stresses (k, 6) in the surface of a half-space, in the unit of the traction, at places
    (k, 2) in elements from the grid's first node.

    size: (2,) of an element; only its proportion counts. square, ratio: see `SubgridTraction`; without `rooted` the
    traction is `ratio` alone, bilinear between nodes. Only tractions nearer than eight mean elements count. The kernels
    fall with the square of the distance r. So each ray from a point contributes the integral of (traction - traction at
    the point) / r over r, times harmonics of the ray's direction. It is taken over √r, in which tractions that vanish
    at the contact's edge as a square root are smooth.
    """
    result = np.zeros((len(places), 6))
    cells, loaded = _cells(square, ratio, rooted)
    step = np.sqrt(_REACH) / _DISTANCES
    weights = 2.0 * step / ((np.arange(_DISTANCES) + 0.5) * step)
    total = weights.sum()
    k = 1.0 - 2.0 * nu
    for p in range(len(places)):
        own = _traction(cells, loaded, places[p, 0], places[p, 1])
        for direction in range(_DIRECTIONS):
            angle = 2.0 * np.pi * (direction + 0.5) / _DIRECTIONS
            c, s, c3, s3 = np.cos(angle), np.sin(angle), np.cos(3.0 * angle), np.sin(3.0 * angle)
            x, y, z = -total * own[0], -total * own[1], -total * own[2]
            for n in range(_DISTANCES):
                away = ((n + 0.5) * step) ** 2
                there = _traction(cells, loaded, places[p, 0] + away * c / size[0], places[p, 1] + away * s / size[1])
                x, y, z = x + weights[n] * there[0], y + weights[n] * there[1], z + weights[n] * there[2]
            result[p, 0] += ((2.0 + 0.5 * nu) * c + 1.5 * nu * c3) * x + 1.5 * nu * (s + s3) * y
            result[p, 1] += 1.5 * nu * (c - c3) * x + ((2.0 + 0.5 * nu) * s - 1.5 * nu * s3) * y
            result[p, 3] += ((1.0 - 0.5 * nu) * s + 1.5 * nu * s3) * x + ((1.0 - 0.5 * nu) * c - 1.5 * nu * c3) * y
            result[p, 0] -= k * np.cos(2.0 * angle) * z
            result[p, 1] += k * np.cos(2.0 * angle) * z
            result[p, 3] -= k * np.sin(2.0 * angle) * z
        for a in range(6):
            result[p, a] /= _DIRECTIONS
        result[p, 0] += (0.5 + nu) * own[2]
        result[p, 1] += (0.5 + nu) * own[2]
        result[p, 2], result[p, 4], result[p, 5] = own[2], own[1], own[0]
    return result


@compiled
def _cells(square: Array, ratio: Array, rooted: bool) -> tuple[Array, BoolArray]:
    """The traction in each cell, from one before the first node on, and whether there is any (n_a + 1, n_t + 1).

    (cells, 28): the square's 16 coefficients by powers of the place in the cell, which without `rooted` is one; then of
    each component of the ratio its value, its slope along and across, and how that changes.
    """
    rows, columns = square.shape
    cells = np.zeros(((rows + 1) * (columns + 1), 28))
    loaded = np.zeros((rows + 1, columns + 1), dtype=np.bool_)
    wide = _bordered(ratio)
    for i in range(rows + 1):
        for j in range(columns + 1):
            cell = cells[i * (columns + 1) + j]
            for a in range(3):
                v00, v01, v10, v11 = wide[i, j, a], wide[i, j + 1, a], wide[i + 1, j, a], wide[i + 1, j + 1, a]
                cell[16 + 4 * a], cell[17 + 4 * a], cell[18 + 4 * a] = v00, v10 - v00, v01 - v00
                cell[19 + 4 * a] = v11 - v10 - v01 + v00
                loaded[i, j] |= v00 != 0.0 or v01 != 0.0 or v10 != 0.0 or v11 != 0.0
            cell[0] = 1.0
            if rooted:
                loaded[i, j] = False
                if 0 < i < rows and 0 < j < columns:
                    cubic = cell[:16].reshape(4, 4)
                    bicubic_coefficients(square, i - 1, j - 1, cubic)
                    largest, least = -np.inf, np.inf
                    for m in range(_SAMPLED + 1):
                        for n in range(_SAMPLED + 1):
                            value = polynomial(cubic, m / _SAMPLED, n / _SAMPLED)
                            largest, least = max(largest, value), min(least, value)
                    # Between the samples it may rise by a little.
                    loaded[i, j] = largest + _ROOM * (largest - least) > 0.0
    return cells, loaded


@inlined
def _bordered(ratio: Array) -> Array:
    """The ratio (n_a, n_t, 3) with one more node on each side, where it is zero."""
    wide = np.zeros((ratio.shape[0] + 2, ratio.shape[1] + 2, 3))
    for i in range(ratio.shape[0]):
        for j in range(ratio.shape[1]):
            for a in range(3):
                wide[i + 1, j + 1, a] = ratio[i, j, a]
    return wide


@inlined
def _traction(cells: Array, loaded: BoolArray, u: float, v: float) -> tuple[float, float, float]:
    """The traction at a place in elements: bilinear times the root of the bicubic square."""
    i, j = int(np.floor(u)), int(np.floor(v))
    x, y, z = 0.0, 0.0, 0.0
    if -1 <= i < loaded.shape[0] - 1 and -1 <= j < loaded.shape[1] - 1 and loaded[i + 1, j + 1]:
        k = np.uint64((i + 1) * loaded.shape[1] + j + 1)
        u, v = u - i, v - j
        square = ((cells[k, 15] * v + cells[k, 14]) * v + cells[k, 13]) * v + cells[k, 12]
        square = square * u + ((cells[k, 11] * v + cells[k, 10]) * v + cells[k, 9]) * v + cells[k, 8]
        square = square * u + ((cells[k, 7] * v + cells[k, 6]) * v + cells[k, 5]) * v + cells[k, 4]
        square = square * u + ((cells[k, 3] * v + cells[k, 2]) * v + cells[k, 1]) * v + cells[k, 0]
        if square > 0.0:
            root, both = np.sqrt(square), u * v
            x = root * (cells[k, 16] + cells[k, 17] * u + cells[k, 18] * v + cells[k, 19] * both)
            y = root * (cells[k, 20] + cells[k, 21] * u + cells[k, 22] * v + cells[k, 23] * both)
            z = root * (cells[k, 24] + cells[k, 25] * u + cells[k, 26] * v + cells[k, 27] * both)
    return x, y, z
