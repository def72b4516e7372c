"""Sections of the measured scars along the motion, beside bowls of the depth and length that a model gives them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from wirewear.diagnosis.model.scar_figures import SCAR_EDGE, SCAR_FIGURES
from wirewear.diagnosis.model.setup import Array
from wirewear.diagnosis.observe.scars import FEWEST_POINTS, above_ground
from wirewear.records import MeasuredScar

#: Share of the scar's width about its middle over which a section is averaged.
STRIP = 0.1


def measured_section(scars: Iterable[MeasuredScar]) -> list[tuple[Array, Array]]:
    """Place [µm] along the motion about the scar's middle, and depth [µm], of each map that has enough points."""
    found = []
    for scar in scars:
        if scar.depth_um.size < FEWEST_POINTS:
            continue
        depth = above_ground(scar)
        weight = np.maximum(depth, 0.0)
        if not weight.sum() > 0.0:
            found.append((scar.x_um, depth.mean(axis=1)))
            continue
        middle_x = float(weight.sum(axis=1) @ scar.x_um / weight.sum())
        middle_y = float(weight.sum(axis=0) @ scar.y_um / weight.sum())
        near = np.abs(scar.y_um - middle_y)
        strip = near <= max(STRIP * float(np.ptp(scar.y_um)), float(near.min()))
        found.append((scar.x_um - middle_x, depth[:, strip].mean(axis=1)))
    return found


def bowl(figures: Array, places: int = 41) -> tuple[Array, Array]:
    """The section of a paraboloid of a scar's figures (4,): places and depths [µm].

    The section over its whole width goes as (1 − x²/a²)^(3/2), so that the length, measured where that is `SCAR_EDGE`
    of its largest, is 2 a √(1 − SCAR_EDGE^(2/3)).
    """
    depth, length = (float(figures[SCAR_FIGURES.index(name)]) for name in ("depth", "length"))
    half = 0.5 * length / np.sqrt(1.0 - SCAR_EDGE ** (2.0 / 3.0))
    x = np.linspace(-half, half, places)
    return x, depth * (1.0 - (x / max(half, 1e-9)) ** 2)
