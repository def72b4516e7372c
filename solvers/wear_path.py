"""Where along a cycle the surfaces meet when they wear: places spread evenly over the slip.

Between two places nothing wears, so they must lie closer together than the surfaces' elements. Both strokes share the
surface: where the places of one are moved a quarter of their distance, those of the other, its mirror image, lie half
way between them, and together they are twice as dense.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Share of the stroke over which the bodies must move against each other for places to be spread over that.
_LEAST_SLIDING_SHARE = 0.25
# Increments from a reversal to the first place, over which the holder springs back and the contact mostly sticks.
_STICK_INCREMENTS = 2
_SHIFT = 0.25


def wear_path(amplitude_mm: float, holder_x_mm: float, increments: int) -> Array:
    """Drive at the ends of the increments of half a cycle from +amplitude to -amplitude, shape (increments,).

    holder_x_mm: by how much the contact has carried the holder along at +amplitude; it springs back as far to the other
    side before the bodies slide.
    """
    carried = min(max(holder_x_mm, 0.0), amplitude_mm)
    slides = amplitude_mm - carried
    if slides < _LEAST_SLIDING_SHARE * amplitude_mm or increments < 2 * _STICK_INCREMENTS:
        steps = np.cos(np.pi * np.arange(1, increments + 1) / increments)
        steps[-1] = -1.0
        return amplitude_mm * np.asarray(steps)
    count = increments - _STICK_INCREMENTS
    spacing = 2.0 * slides / count
    begin = amplitude_mm - 2.0 * carried
    places = begin - spacing * (np.arange(count) + _SHIFT)
    stick = np.linspace(amplitude_mm, places[0], _STICK_INCREMENTS + 1)[1:-1]
    return np.concatenate([stick, places, [-amplitude_mm]])
