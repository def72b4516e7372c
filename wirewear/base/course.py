"""Course of a quantity over the cycles of a test, from an initial towards a final value."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import exp, expm1, log
from typing import overload

import numpy as np

from geometry.arrays import Array

_FLAT = 1e-9  #: An energy that falls as the reciprocal of the cycles within this has a logarithm for its integral.


@dataclass(frozen=True)
class Course:
    """Value that changes exponentially from initial to final: f + (i − f) exp(−(n/n_c)^m) after n cycles, unless
    `order` is not 0.
    """

    initial: float
    final: float
    cycles: float = 1.0  #: n_c, after which 63 % of the change has happened.
    #: m: 1 for a plain exponential; below 1 the change begins earlier and ends later, as for many processes at
    #: different rates (Kohlrausch).
    steepness: float = 1.0
    #: k: the remaining change r falls as dr ∝ r^(1 + k): 0 exponential, 1 hyperbolic, −1 linear until it ends;
    #: r = (1 + (e^k − 1)(n/n_c)^m)^(−1/k).
    order: float = 0.0
    lasting: float = 0.0  #: Share of the change that never happens.

    @classmethod
    def constant(cls, value: float) -> "Course":
        """Course that always has this value."""
        return cls(value, value)

    @overload
    def at(self, cycles: float) -> float: ...

    @overload
    def at(self, cycles: Array) -> Array: ...

    def at(self, cycles: float | Array) -> float | Array:
        """Values after these numbers of cycles: a number for a number, (n,) for (n,)."""
        passed = cycles / self.cycles
        if self.steepness != 1.0:
            passed = passed**self.steepness
        left = np.exp(-passed) if isinstance(passed, np.ndarray) else exp(-passed)
        # Kinetics of an order nearer to the first are those of the first, as their law has no digits left.
        if abs(self.order) > 1e-6:
            base = np.maximum(1.0 + expm1(self.order) * passed, 0.0)
            # What ends has a power of nothing left, which is nothing.
            left = base ** (-1.0 / self.order) if self.order < 0.0 else np.maximum(base, 1.0) ** (-1.0 / self.order)
            left = left if isinstance(passed, np.ndarray) else float(left)
        return self.final + (self.initial - self.final) * (self.lasting + (1.0 - self.lasting) * left)

    def times(self, factor: float) -> "Course":
        """Course with its initial and final value multiplied by a factor."""
        return replace(self, initial=factor * self.initial, final=factor * self.final)


def enclosed_energy(cycles: Sequence[float] | Array, per_cycle: Sequence[float] | Array) -> float:
    """Sum of an energy per cycle, in its unit, over all cycles from the first to the last of `cycles`; per_cycle: the
    energy at each of these increasing numbers.

    Between two of them the energy per cycle is taken as a power of the number of cycles.
    """
    return sum(_enclosed(*pair) for pair in pairwise(zip(cycles, per_cycle, strict=True)))


def _enclosed(earlier: tuple[float, float], later: tuple[float, float]) -> float:
    (start, before), (end, after) = earlier, later
    if before <= 0.0 or after <= 0.0:
        return 0.5 * (before + after) * (end - start)
    growth = log(after * end / (before * start))
    return before * start * log(end / start) * (expm1(growth) / growth if abs(growth) > _FLAT else 1.0)
