"""What happens at once during a test and passes off again, the same for all forward models."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp


@dataclass(frozen=True)
class Jump:
    """A factor that jumps from 1 at a cycle and comes back, 63 % of the way after `recovery_cycles`."""

    cycle: float
    factor: float
    recovery_cycles: float

    def at(self, cycle: float) -> float:
        """The factor at a cycle."""
        if cycle < self.cycle:
            return 1.0
        return 1.0 + (self.factor - 1.0) * exp(-(cycle - self.cycle) / self.recovery_cycles)
