"""How a quantity changes over the cycles of a test: exponentially from one value towards another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import exp, expm1, log
from typing import overload

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Course:
    """A value that goes exponentially from the initial to the final one: f + (i − f) exp(−(n/n_c)^m).

    cycles: n_c, after which 63 % of the change has happened. steepness: m, 1 for a plain exponential; below it the
    change begins earlier and ends later, as where many processes run in side by side (Kohlrausch).
    """

    initial: float
    final: float
    cycles: float = 1.0
    steepness: float = 1.0

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
        if self.steepness != 1.0:
            passed = passed**self.steepness
        gone = np.exp(-passed) if isinstance(passed, np.ndarray) else exp(-passed)
        return self.final + (self.initial - self.final) * gone

    def times(self, factor: float) -> Course:
        """The course with both values multiplied."""
        return replace(self, initial=factor * self.initial, final=factor * self.final)


#: An energy that falls as the reciprocal of the cycles within this has a logarithm for its integral.
_FLAT = 1e-9


def enclosed_energy(
    cycles: Sequence[float] | NDArray[np.float64], per_cycle: Sequence[float] | NDArray[np.float64]
) -> float:
    """Sum of what is given per cycle, from the first of the cycles, which increase, to the last.

    Between two of them it is taken to be a power of the cycles.
    """
    return sum(_enclosed(*pair) for pair in pairwise(zip(cycles, per_cycle, strict=True)))


def _enclosed(earlier: tuple[float, float], later: tuple[float, float]) -> float:
    (start, before), (end, after) = earlier, later
    if before <= 0.0 or after <= 0.0:
        return 0.5 * (before + after) * (end - start)
    growth = log(after * end / (before * start))
    return before * start * log(end / start) * (expm1(growth) / growth if abs(growth) > _FLAT else 1.0)
