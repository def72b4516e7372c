"""The rig that holds the upper body: what moves it and what resists."""

from __future__ import annotations

from dataclasses import dataclass

from solvers.errors import SolverError


@dataclass(frozen=True)
class Holder:
    """A holder that moves along the motion (x) and the normal (z) only.

    tangential_compliance_mm_per_N: of the spring to ground on the motion axis; 0 is a rigid rig.
    normal_load_N: load when the bodies have just been pressed together.
    normal_stiffness_N_per_mm: of the loading spring; the load falls by this much per mm that the holder descends
    afterwards; 0 is a dead weight.
    """

    normal_load_N: float
    tangential_compliance_mm_per_N: float = 0.0
    normal_stiffness_N_per_mm: float = 0.0

    def __post_init__(self) -> None:
        if not self.normal_load_N > 0.0:
            raise SolverError(f"the normal load must be positive, but is {self.normal_load_N} N")
        if self.tangential_compliance_mm_per_N < 0.0 or self.normal_stiffness_N_per_mm < 0.0:
            raise SolverError("the holder's compliance and its loading spring's stiffness must not be negative")

    def normal_force_N(self, height_mm: float, pressed_height_mm: float) -> float:
        """Load at the holder's height, given its height when the bodies had just been pressed together."""
        return self.normal_load_N + self.normal_stiffness_N_per_mm * (height_mm - pressed_height_mm)
