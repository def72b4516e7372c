"""How far the fast model and other solvers differ on runs without a gap: its numerical freedoms, and hooks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

#: Standard deviations of the fast model's numerical freedoms.
NUMERICAL = {
    "slope_factor": 0.1,
    "slope_trend": 0.08,
    "tip_factor": 0.12,
    "tip_trend": 0.05,
    "stretch": 0.1,
    "stick_factor": 0.2,
    "angle_tilt": 0.002,
    "angle_trend": 0.0025,
    "scar_factor": 0.007,
    "wear": 0.015,
    "friction": 0.0025,
    "load": 0.001,
    "compliance": 0.03,
}

#: Where they lie on average, if not at their neutral value: a quick run sees a scar longer than the slip and blunts its
#: walls, so that the state that fits others' loops is one of less wear with steeper slopes.
EXPECTED: Mapping[str, Any] = {
    "slope_factor": 1.24,
    "slope_trend": -0.035,
    "tip_factor": -0.09,
    "tip_trend": 0.06,
    "stretch": 1.24,
}

#: Shares of the force that slopes cause by which hooks differ as a whole, and at one end of the stroke from the other.
HOOK, SIDE = 0.09, 0.12

#: Hooks as a whole differ over this difference of the cycles' logarithm.
HOOK_REACH = 0.7

#: Share of the remainder's variance that passes from one logged cycle to the next, as ripples of worn surfaces do; both
#: shares are correlated over these differences of the cycles' logarithm.
PASSING, PASSING_REACH, LASTING_REACH = 0.5, 0.15, 1.5

#: Correlation of both branches under a turn of the loop: of solvers' differences, of a free difference.
TURNED, FREE_TURNED = 0.8, 0.5

#: Ripples are alike at both ends of the stroke by this share of what lasting differences are.
PASSING_TURNED = 0.5
