"""The figures that scars are compared by, and their skew, from which the crossing angle follows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wirewear.diagnosis.calibration import constants

Array = NDArray[np.float64]

_KNOWN = constants("model.scar_figures")

#: Columns of a scar's figures.
SCAR_FIGURES = ("volume", "depth", "length", "width")

#: A depth above this share of the deepest point belongs to the scar when its length and width are measured.
SCAR_EDGE = _KNOWN.number("edge")

#: For a skew, depths below this share of the deepest are left out: the ground counts by its distance squared.
_SKEW_EDGE = _KNOWN.number("skew_edge")


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


def scar_skew(x_um: Array, y_um: Array, depth_um: Array) -> float:
    """∫d x y / ∫d y² about the centre of a map (n_x, n_y) with x along the motion; NaN of a map without a scar.

    A cylinder whose axis is turned by ε from the normal to the motion leaves d = h − y²/2R − (x + ε y − s)²/2R on one
    along the motion, whatever its position s: every scar that is swept by it is sheared by x → x − ε y, and this is
    −tan ε on both wires (geometry).
    """
    depth = np.where(depth_um > _SKEW_EDGE * float(np.max(depth_um)), depth_um, 0.0)
    volume = float(depth.sum())
    if not volume > 0.0:
        return float("nan")
    x = x_um - float(depth.sum(axis=1) @ x_um) / volume
    y = y_um - float(depth.sum(axis=0) @ y_um) / volume
    across = float(depth.sum(axis=0) @ y**2)
    return float(x @ depth @ y) / across if across > 0.0 else float("nan")
