"""Rectangular cells under even pressures on an elastic half-space: how they displace each other."""

import numpy as np

from geometry.arrays import Array
from solvers.jit_cache import compiled, inlined

_APART = 4.0  #: Distance of two cells over their sides beyond which a series serves for how one displaces the other.


def punch_stiffness(x: Array, y: Array, wide: Array, high: Array) -> float:
    """Load over depth of a flat punch on a half-space, over π times the contact modulus, in mm.
    The punch is made of rectangles with middles (x, y) and sizes (wide, high), each (n,) in mm, under an even pressure
    each.
    """
    depth = depth_of_cells(x[:, None] - x, y[:, None] - y, (wide, high), (wide, high))
    return float((wide * high) @ np.linalg.solve(depth, np.ones(len(x))))


def depth_of_cells(along: Array, across: Array, own: tuple[Array, Array], by: tuple[Array, Array]) -> Array:
    """Mean displacement (n, m) of n rectangles on a half-space, into it, by unit pressure on m others, times π E*, in
    mm: as finite elements are made to give it (`solvers.elasticity.patch_compliance`).

    along, across: (n, m) distances of their middles in mm. own, by: their sizes, (n,) and (m,) each.
    """
    return np.asarray(_depths(along, across, *own, *by))


@compiled
def _depths(along: Array, across: Array, own_wide: Array, own_high: Array, by_wide: Array, by_high: Array) -> Array:
    depth = np.empty(along.shape)
    for i in range(len(own_wide)):
        for j in range(len(by_wide)):
            x, y, area = along[i, j], across[i, j], by_wide[j] * by_high[j]
            wide, high = own_wide[i] ** 2 + by_wide[j] ** 2, own_high[i] ** 2 + by_high[j] ** 2
            square = x**2 + y**2
            if square >= _APART**2 * max(wide, high):
                second = wide * (3.0 * x**2 / square - 1.0) + high * (3.0 * y**2 / square - 1.0)
                depth[i, j] = area * (1.0 + second / (24.0 * square)) / np.sqrt(square)
                continue
            exact = 0.0
            for a in (0.5, -0.5):
                for b in (0.5, -0.5):
                    for c in (0.5, -0.5):
                        for d in (0.5, -0.5):
                            place = x + a * own_wide[i] + b * by_wide[j], y + c * own_high[i] + d * by_high[j]
                            exact += 16.0 * a * b * c * d * _antiderivative(place[0], place[1])
            depth[i, j] = exact / (own_wide[i] * own_high[i])
    return depth


@inlined
def _antiderivative(x: float, y: float) -> float:
    """The integral of 1/√(x² + y²), taken twice over x and twice over y, at distances x and y in mm."""
    x, y = max(abs(x), 1e-300), max(abs(y), 1e-300)
    far = np.sqrt(x**2 + y**2)
    return float(0.5 * x * y * (y * np.log((x + far) / y) + x * np.log((y + far) / x)) - far**3 / 6.0)
