"""Averages of stresses over critical distances: about which places, with what weights, between lines of a mesh.

A kernel is a function of a point's depth in mm that gives the places (k, 3) over which its stress is averaged, and
their weights (k,), which sum to 1; places are in mm along and across from the point, and in depth below the surface.
"""

from collections.abc import Callable
from math import ceil

import numpy as np
from scipy.sparse import csr_matrix

from geometry.arrays import Array
from geometry.patch import sides_of
from wirewear.test.life import LifeTable

#: Radii of the area and of the volume over the critical distance (Bellett et al., Int. J. Fatigue 27 (2005) 1103).
_RADII = (1.32, 1.54)


def kernel_of(table: LifeTable, *, plane: bool) -> Callable[[float], tuple[Array, Array]]:
    """The kernel that a table states, in this order: a ball of diameter averaging_length_um; by the critical distance
    L the point L/2 below, the line down to 2 L, or a ball of radius 1.54 L; a ball of diameter grain_um; the point
    itself. plane: True for a line contact, where balls are discs and the radius is 1.32 L.
    """
    distance = 1e-3 * table.distance_um
    stated = table.averaging_length_um or (None if distance else table.grain_um)
    nodes, weights = np.polynomial.legendre.leggauss(5)
    if stated is None and (table.averaging == "point" or distance == 0.0):
        return lambda depth: (np.array([[0.0, 0.0, depth + 0.5 * distance]]), np.ones(1))
    if stated is None and table.averaging == "line":
        along = distance * (1.0 + nodes)
        return lambda depth: (np.column_stack([0.0 * along, 0.0 * along, depth + along]), 0.5 * weights)
    radius = 0.5e-3 * stated if stated is not None else _RADII[0 if plane else 1] * distance

    def over_ball(depth: float) -> tuple[Array, Array]:
        """Integration points of the part of a ball that lies in the body: discs, each by a rule exact to the fifth
        power.
        """
        top = max(-radius, -depth)
        height = top + 0.5 * (radius - top) * (1.0 + nodes)
        reach = np.sqrt(np.maximum(radius**2 - height**2, 0.0))
        if plane:
            sides, part, area = np.column_stack([nodes, 0.0 * nodes]), 0.5 * weights, reach
        else:
            # Stroud, Approximate Calculation of Multiple Integrals (1971), S2: 5-1.
            turn = np.pi / 3.0 * np.arange(6)
            sides = np.vstack([[0.0, 0.0], (2.0 / 3.0) ** 0.5 * np.column_stack([np.cos(turn), np.sin(turn)])])
            part, area = np.array([2.0, *6 * [1.0]]) / 8.0, reach**2
        places = reach[:, None, None] * sides
        depths = np.broadcast_to(depth + height[:, None, None], (*places.shape[:2], 1))
        share = np.outer(weights * area, part).ravel()
        return np.concatenate([places, depths], axis=2).reshape(-1, 3), share / share.sum()

    return over_ball


def averaging_radius_mm(table: LifeTable, *, plane: bool) -> float:
    """Largest component in mm of the distance from a point over which its stress is averaged; 0 without averaging.
    plane: True for a line contact.
    """
    places, _ = kernel_of(table, plane=plane)(1e3)
    return float(np.abs(places - [0.0, 0.0, 1e3]).max())


def widened(lines: Array, reach: float, lowest: float, highest: float) -> Array:
    """Grid lines (l,) continued on both sides with their outermost spacing, by `reach`, but not beyond `lowest` and
    `highest`; a single line as it is.
    """
    if len(lines) == 1:
        return lines
    first, last = lines[1] - lines[0], lines[-1] - lines[-2]
    below = lines[0] - first * np.arange(ceil(reach / first), 0, -1)
    above = lines[-1] + last * np.arange(1, ceil(reach / last) + 1)
    return np.concatenate([below[below >= lowest], lines, above[above <= highest]])


def averaging(
    to: tuple[Array, ...], of: tuple[Array, ...], kernel: Callable[[float], tuple[Array, Array]]
) -> csr_matrix:
    """The matrix of averages about points, from values at other points, both at all crossings of lines along, across
    and in depth in mm, flattened in this order. to, of: the lines of the points that averages are about, and of those
    with values, between which is interpolated linearly.
    """
    (axial, transverse, depths), count = to, [len(lines) for lines in of]
    columns_before = np.arange(len(axial))[:, None] * len(transverse) + np.arange(len(transverse))
    found = []
    for level, depth in enumerate(depths):
        row = columns_before * len(depths) + level
        for (x, y, z), weight in zip(*kernel(float(depth)), strict=True):
            for i, u in sides_of(of[0], axial + x):
                for j, v in sides_of(of[1], transverse + y):
                    for k, w in sides_of(of[2], np.array([z])):
                        column = (i[:, None] * count[1] + j) * count[2] + k[0]
                        share = weight * w[0] * u[:, None] * v
                        found.append((share.ravel(), row.ravel(), column.ravel()))
    shares, rows, columns = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return csr_matrix((shares, (rows, columns)), shape=(columns_before.size * len(depths), int(np.prod(count))))
