"""How far the fast model and other solvers differ on runs without a gap: its numerical freedoms, and hooks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from wirewear.diagnosis.calibration import constants

_HOOKS, _SMOOTH = constants("model.numerical.hooks"), constants("model.numerical.smooth")

#: Standard deviations of the fast model's numerical freedoms.
NUMERICAL: Mapping[str, float] = constants("model.numerical.freedoms").all()

#: Where they lie on average, if not at their neutral value: a quick run sees a scar longer than the slip and blunts its
#: walls, so that the state that fits others' loops is one of less wear with steeper slopes.
EXPECTED: Mapping[str, Any] = constants("model.numerical.expected").all()

#: Shares of the force that slopes cause by which hooks differ as a whole, and at one end of the stroke from the other.
HOOK, SIDE = _HOOKS.each("whole", "side")

#: Hooks as a whole differ over this difference of the cycles' logarithm.
HOOK_REACH = _HOOKS.number("whole_reach")

#: Share of the remainder's variance that passes from one logged cycle to the next, as ripples of worn surfaces do; both
#: shares are correlated over these differences of the cycles' logarithm.
PASSING = _SMOOTH.number("passing")
PASSING_REACH, LASTING_REACH = _SMOOTH.each("passing_reach", "lasting_reach")

#: Correlation of both branches under a turn of the loop: of solvers' differences, of a free difference.
TURNED, FREE_TURNED = _SMOOTH.each("turned", "free_turned")

#: Ripples are alike at both ends of the stroke by this share of what lasting differences are.
PASSING_TURNED = _SMOOTH.number("passing_turned")
