"""The figures that scars are compared by."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Columns of a scar's figures.
SCAR_FIGURES = ("volume", "depth", "length", "width")

#: A depth above this share of the deepest point belongs to the scar when its length and width are measured.
SCAR_EDGE = 0.25


def scar_figures(x_um: Array, y_um: Array, depth_um: Array) -> list[float]:
    """Volume [µm³], depth, length along x and width along y [µm] of a map (n_x, n_y) without holes."""
    volume = float(np.trapezoid(np.trapezoid(depth_um, y_um, axis=1), x_um))
    along = np.asarray(np.trapezoid(depth_um, y_um, axis=1))
    across = np.asarray(np.trapezoid(depth_um, x_um, axis=0))
    deep = float(np.partition(depth_um.ravel(), -5)[-5])
    if volume <= 0.0 or deep <= 0.0:
        return [0.0, 0.0, 0.0, 0.0]
    return [volume, deep, _extent(x_um, along), _extent(y_um, across)]


def _extent(line: Array, section: Array) -> float:
    """Width of a section at `SCAR_EDGE` of its height, linear between points."""
    level = SCAR_EDGE * float(section.max())
    inside = np.flatnonzero(section >= level)
    first, last = int(inside[0]), int(inside[-1])

    def crossing(outer: int, inner: int) -> float:
        if outer < 0 or outer >= line.size or section[inner] == section[outer]:
            return float(line[inner])
        share = (level - section[outer]) / (section[inner] - section[outer])
        return float(line[outer] + share * (line[inner] - line[outer]))

    return crossing(last + 1, last) - crossing(first - 1, first)
