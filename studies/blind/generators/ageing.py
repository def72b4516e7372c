"""What changes over the cycles of a test by laws other than an exponential, the same for all forward models."""

from dataclasses import dataclass
from math import exp
from typing import Protocol


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


@dataclass(frozen=True)
class Film:
    """A factor on friction, 1 − share before the film breaks and 1 after it: half of it is gone at `cycle`.

    What is left of the film is 1/(1 + (n/n_b)^k): patches of it break at cycles spread about n_b, the closer the larger
    `abruptness` k. A negative share is a film that rubs more than what lies under it.
    """

    share: float
    cycle: float
    abruptness: float

    def at(self, cycle: float) -> float:
        """The factor at a cycle."""
        left = 1.0 / (1.0 + float((cycle / self.cycle) ** self.abruptness))
        return 1.0 - self.share * left


class Factor(Protocol):
    """A factor over the cycles, on friction, load or wear."""

    def at(self, cycle: float) -> float:
        """The factor at a cycle."""
        ...


@dataclass(frozen=True)
class Constant:
    """A factor that does not change with the cycles."""

    factor: float

    def at(self, _cycle: float) -> float:
        return self.factor


@dataclass(frozen=True)
class Growth:
    """A value that grows from nothing, v (n/n_e)^p: evenly as wear does (p = 1), or ever faster as a crack does.

    `final` is reached at `cycles` n_e and kept afterwards.
    """

    final: float
    cycles: float
    power: float = 1.0

    def at(self, cycle: float) -> float:
        """The value at a cycle."""
        return self.final * float(min(max(cycle, 0.0) / self.cycles, 1.0) ** self.power)
