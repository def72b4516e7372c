"""One branch of a measured loop, from reversal to reversal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.setup import Array

#: A force level lies on the stick branch if it is below this share of the rise from reversal to knee.
STICK_SHARE = constants("observe.branch").number("stick_share")


@dataclass(frozen=True, eq=False)
class ObservedBranch:
    """One branch of a measured loop in order of travel: displacement and force times its direction, so that they rise.

    All arrays are (m,); the normal force is None where it was not measured. `reversal_N` is the force at which the
    other branch ends, from which this one begins.
    """

    sign: int
    displacement_um: Array
    force_N: Array
    knee: int
    normal_N: Array | None = None
    reversal_N: float = np.inf

    @property
    def knee_um(self) -> float:
        """Displacement at which sliding begins, times the direction."""
        return float(self.displacement_um[self.knee])

    @property
    def stick_top_N(self) -> float:
        """Force up to which the branch sticks for certain."""
        low = min(float(self.force_N[: self.knee + 1].min()), self.reversal_N)
        return low + STICK_SHARE * (float(self.force_N[self.knee]) - low)

    @property
    def step_at_zero_um(self) -> float:
        """Displacement between the samples before and after the force changes its sign; 0 where it does not."""
        after = int(np.count_nonzero(self.force_N[: self.knee + 1] <= 0.0))
        if not 0 < after <= self.knee:
            return 0.0
        return float(abs(self.displacement_um[after] - self.displacement_um[after - 1]))
