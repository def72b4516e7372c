"""How what is true of a test changes over its cycles, the same for all forward models."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp


@dataclass(frozen=True)
class Course:
    """A value that goes exponentially from the initial to the final one, 63 % of the way after `cycles`."""

    initial: float
    final: float
    cycles: float = 1.0

    @classmethod
    def constant(cls, value: float) -> Course:
        """A value that stays."""
        return cls(value, value)

    def at(self, cycle: float) -> float:
        """The value at a cycle."""
        return self.final + (self.initial - self.final) * exp(-cycle / self.cycles)

    def times(self, factor: float) -> Course:
        """The course with both values multiplied."""
        return Course(factor * self.initial, factor * self.final, self.cycles)


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
