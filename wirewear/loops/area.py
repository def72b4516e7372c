"""The area that a closed loop encloses: the energy that it dissipates."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def enclosed_area(x: Array, y: Array) -> float:
    """Area of a closed loop (n,) of samples joined by straight lines, the last one with the first.

    Positive when it turns clockwise, as a loop that dissipates does.
    """
    return float(enclosed_areas(x[None], y[None])[0])


def enclosed_areas(x: Array, y: Array) -> Array:
    """Areas (m,) of closed loops (m, n)."""
    # About its own middle, a loop far from the origin loses no digits.
    x, y = x - x.mean(axis=1, keepdims=True), y - y.mean(axis=1, keepdims=True)
    after_x, after_y = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
    return 0.5 * np.asarray(np.einsum("ij,ij->i", after_x, y) - np.einsum("ij,ij->i", x, after_y))
