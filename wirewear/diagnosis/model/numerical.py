"""How far the fast model and other solvers differ on runs without a gap: its numerical freedoms, and what remains."""

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

#: The remainder: share of the force that slopes cause, point by point, as a whole (hook) and at one end of the stroke
#: against the other (side), of the plateau force, displacements, shares of the plateau force, of what slopes make of it
#: just past the knee and of how high walls are there, and relative ones; of all these, what is not smooth from level to
#: level (rough), between walls and at them.
REMAINDER = {
    "slope": 0.12,
    "hook": 0.09,
    "side": 0.12,
    "plateau": 0.0018,
    "stick_um": 0.11,
    "tip": 0.08,
    "knee": 0.003,
    "knee_slope": 0.28,
    "knee_wall": 0.3,
    "relative": 0.003,
    "normal": 0.001,
    "scar": 0.006,
    "skew": 0.0015,
    "rough": 0.13,
    "rough_wall": 0.3,
}

#: Share of the remainder's variance that passes from one logged cycle to the next, as ripples of worn surfaces do; both
#: shares are correlated over these differences of the cycles' logarithm.
PASSING, PASSING_REACH, LASTING_REACH = 0.5, 0.15, 1.5

#: Ripples are alike at both ends of the stroke by this share of what lasting differences are.
PASSING_SYMMETRIC = 0.5

#: Walls are high where slopes raise the force by this share of it.
WALL_HEIGHT = 0.1

#: They stand beyond this share of the amplitude.
WALL_PLACE = 0.7

#: Hooks as a whole differ over this difference of the cycles' logarithm.
HOOK_REACH = 0.7
