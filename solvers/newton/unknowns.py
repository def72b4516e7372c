"""Where in the equations of one Newton iteration which unknown stands."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class Unknowns:
    """Normal tractions of the nodes `on` (a,), tangential ones of the nodes `tan` (m,), then the holder's position.

    size: number of unknowns.
    The rows of the equations stand in the same order: no gap, no slip or the friction law, the holder's equilibrium.
    """

    on: IntArray
    tan: IntArray
    size: int = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "size", len(self.on) + 2 * len(self.tan) + 3)

    @property
    def p(self) -> slice:
        """Normal tractions."""
        return slice(0, len(self.on))

    def q(self, tangent: int) -> slice:
        """Tractions along the first (0) or second (1) tangent."""
        first = len(self.on) + tangent * len(self.tan)
        return slice(first, first + len(self.tan))

    @property
    def tractions(self) -> slice:
        """All tractions."""
        return slice(0, len(self.on) + 2 * len(self.tan))

    @property
    def z(self) -> int:
        """Height of the holder."""
        return self.size - 3

    @property
    def x(self) -> int:
        """Position of the holder along the motion."""
        return self.size - 2

    @property
    def t(self) -> int:
        """Tilt of the holder."""
        return self.size - 1
