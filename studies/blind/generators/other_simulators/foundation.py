"""Simulator 2, for development: crossed wires on an elastic foundation that slide by Dahl's law.

Foundation: Johnson, Contact Mechanics (1985), section 4.3; its stiffness is that of a flat punch on the area that
touches, as in Popov's reduction of dimensions (Popov & Heß, Method of Dimensionality Reduction, 2015). Tangentially it
is softer by Mindlin's ratio. Friction: Dahl, Aerospace Corp. TOR-0158 (1968), with an exponent of one, which is also
LuGre's law at low speed (Canudas de Wit et al., IEEE Trans. Autom. Control 40 (1995) 419).
"""

from math import pi, sqrt

import numpy as np

from studies.blind.generators.other_simulators.pair import Array, Layer, Pair


class Foundation:
    """Springs side by side, as stiff as half-spaces under a punch of the area that touches."""

    def __init__(self, cell_mm2: float, modulus_MPa: float, area_mm2: float) -> None:
        """Nothing is worn yet."""
        self.cell, self.modulus, self.area = cell_mm2, modulus_MPa, area_mm2

    @property
    def stiffness_N_per_mm(self) -> float:
        """Of a flat punch, 2 E* a."""
        return 2.0 * self.modulus * sqrt(self.area / pi)

    def press(self, gap_mm: Array, load_N: float, local: Array | float) -> tuple[Array, float]:
        """Pressures under a load and the approach, by Newton's method on the approach."""
        soft = np.broadcast_to(self.area / self.stiffness_N_per_mm + local, gap_mm.shape)
        approach = float(gap_mm.min()) + load_N / self.cell * float(soft.max())
        for _ in range(60):
            pressure = np.maximum(approach - gap_mm, 0.0) / soft
            step = (load_N / self.cell - pressure.sum()) / (1.0 / soft)[pressure > 0.0].sum()
            approach += float(step)
            if abs(step) < 1e-9 * abs(approach):
                break
        pressure = np.maximum(approach - gap_mm, 0.0) / soft
        return pressure, approach


class FoundationWires(Pair):
    """Crossed wires that slide by Dahl's law."""

    def __init__(
        self, shape: Array, steps: tuple[float, float], reach: float, modulus_MPa: float, easier: float
    ) -> None:
        """Nothing is worn yet."""
        # Hertz's area of a sphere under a small load, until a first load has been seen.
        self.foundation = Foundation(steps[0] * steps[1], modulus_MPa, 4.0 * steps[0] * steps[1])
        super().__init__(shape, steps, reach, 1, self.foundation)
        self.easier = easier

    def settle(self, load_N: float, layer: Layer) -> None:
        """See how large the area is that touches."""
        for _ in range(4):
            pressure, _ = self.foundation.press(*self._problem(0.0, load_N, layer))
            self.foundation.area = max(self.cell_mm2 * float((pressure > 0.0).sum()), 4.0 * self.cell_mm2)

    def lag_mm(self, friction: float, load_N: float) -> float:
        """Elastic displacement under the full friction."""
        return friction * load_N * self.easier / self.foundation.stiffness_N_per_mm

    def stroke(self, way_mm: Array, half_mm: float, friction: float, load_N: float) -> Array:
        """Friction over its limit along a stroke that begins at a reversal."""
        length = 2.0 * self.lag_mm(friction, load_N)
        return np.asarray(1.0 - (1.0 + np.tanh(half_mm / length)) * np.exp(-way_mm / length))
