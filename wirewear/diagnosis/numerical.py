"""How far the fast model and other solvers differ on runs without a gap: its numerical freedoms, and what remains."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

#: Standard deviations of the fast model's numerical freedoms.
NUMERICAL = {
    "slope_factor": 0.06,
    "slope_trend": 0.14,
    "tip_factor": 0.11,
    "stretch": 0.05,
    "stick_factor": 0.2,
    "angle_tilt": 0.003,
    "angle_trend": 0.003,
    "scar_factor": 0.01,
    "wear": 0.015,
    "friction": 0.003,
    "load": 0.001,
    "compliance": 0.04,
}

#: Where they lie on average, if not at their neutral value: a quick run blunts the walls of a deep scar.
EXPECTED: Mapping[str, Any] = {"slope_trend": 0.2, "tip_factor": -0.12, "stretch": 1.02}

#: The remainder: share of the force that slopes cause, of the plateau force, displacements, shares of the plateau force
#: and of what slopes make of it just past the knee, and relative ones.
REMAINDER = {
    "slope": 0.2,
    "plateau": 0.0027,
    "stick_um": 0.2,
    "tip": 0.08,
    "knee": 0.006,
    "knee_slope": 0.5,
    "relative": 0.0045,
    "normal": 0.003,
    "scar": 0.012,
    "skew": 0.003,
    "rough": 0.15,
}

#: Share of the remainder's variance that passes from one logged cycle to the next, as ripples of worn surfaces do; both
#: shares are correlated over these differences of the cycles' logarithm.
PASSING, PASSING_REACH, LASTING_REACH = 0.3, 0.15, 1.5
