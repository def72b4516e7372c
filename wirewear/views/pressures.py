"""Which pressures a page shows over the cycles: means over a length, of older results those of single nodes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wirewear.results import PRESSURE_LENGTH

#: A column of the evolution, what it is called, and its dashes in SVG.
Course = tuple[str, str, str]

_OF_NODES: tuple[Course, ...] = (
    ("max_pressure_MPa", "largest at a node", "5 3"),
    ("mid_stroke_pressure_MPa", "at a node at mid-stroke", ""),
)


def pressure_courses(evolution: Mapping[str, NDArray[np.float64]], settings: Mapping[str, Any]) -> tuple[Course, ...]:
    """The largest pressure of the cycle and that about mid-stroke, of a run's evolution and settings."""
    if PRESSURE_LENGTH not in settings:
        return _OF_NODES
    over = f"mean over {settings[PRESSURE_LENGTH]:.3g} µm"
    found: tuple[Course, ...] = (
        ("max_mean_pressure_MPa", f"largest {over}", "5 3"),
        ("mid_stroke_mean_pressure_MPa", f"{over} at mid-stroke", ""),
    )
    return found if all(name in evolution for name, _, _ in found) else _OF_NODES
