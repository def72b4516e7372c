"""How a quantity changes over the cycles of a test: exponentially from one value towards another."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp
from typing import overload

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Course:
    """A value that goes exponentially from the initial to the final one: f + (i − f) exp(−n/n_c).

    cycles: n_c, after which 63 % of the change has happened.
    """

    initial: float
    final: float
    cycles: float = 1.0

    @classmethod
    def constant(cls, value: float) -> Course:
        """A value that stays."""
        return cls(value, value)

    @overload
    def at(self, cycles: float) -> float: ...

    @overload
    def at(self, cycles: NDArray[np.float64]) -> NDArray[np.float64]: ...

    def at(self, cycles: float | NDArray[np.float64]) -> float | NDArray[np.float64]:
        """The value after so many cycles, one or (n,)."""
        passed = cycles / self.cycles
        gone = np.exp(-passed) if isinstance(passed, np.ndarray) else exp(-passed)
        return self.final + (self.initial - self.final) * gone

    def times(self, factor: float) -> Course:
        """The course with both values multiplied."""
        return Course(factor * self.initial, factor * self.final, self.cycles)
