"""Skew of a scar: how far its outline is sheared along the motion, from which the crossing angle follows."""

from __future__ import annotations

import numpy as np

from wirewear.diagnosis.layout import Array

#: Depths below this share of the deepest are left out: the ground's errors would count by their distance squared.
_EDGE = 0.15


def scar_skew(x_um: Array, y_um: Array, depth_um: Array) -> float:
    """∫d x y / ∫d y² about the centre of a map (n_x, n_y) with x along the motion; NaN of a map without a scar.

    A cylinder whose axis is turned by ε from the normal to the motion leaves d = h − y²/2R − (x + ε y − s)²/2R on one
    along the motion, whatever its position s: every scar that is swept by it is sheared by x → x − ε y, and this is
    −tan ε on both wires (geometry).
    """
    depth = np.where(depth_um > _EDGE * float(np.max(depth_um)), depth_um, 0.0)
    volume = float(depth.sum())
    if not volume > 0.0:
        return float("nan")
    x = x_um - float(depth.sum(axis=1) @ x_um) / volume
    y = y_um - float(depth.sum(axis=0) @ y_um) / volume
    across = float(depth.sum(axis=0) @ y**2)
    return float(x @ depth @ y) / across if across > 0.0 else float("nan")
