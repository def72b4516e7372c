"""Simulator 3, for development: crossed wires as strips across the motion, each a parabolic segment in closed form.

A strip that has been worn to the depth h at its middle touches over the chord 2 √(2 R h), as a cylinder in a groove of
its own radius (Archard's geometry of crossed cylinders, J. Appl. Phys. 24 (1953) 981). Strips are springs of Popov's
method: E* per length. Friction: Iwan's parallel sliders, J. Appl. Mech. 33 (1966) 893, whose limits spread evenly; its
coefficient follows speed and pressure by small powers.
"""

from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray

from studies.blind.generators.other_simulators.foundation import Foundation
from studies.blind.generators.other_simulators.pair import Array, Layer, Pair

WEAKEST = 0.5  #: Weakest slider's limit over the mean one.
#: Lines across half a cell of the scars' maps, and the least overlap of strips that would touch.
ACROSS_LINES, LEAST_mm = 24, 1e-5


class StripWires(Pair):
    """Crossed wires at a right angle; the grid has one cell across, and pressures are means over it."""

    def __init__(
        self, shape: Array, steps: tuple[float, float], reach: float, modulus_MPa: float, easier: float
    ) -> None:
        """Nothing is worn yet."""
        springs = Foundation(steps[0] * steps[1], modulus_MPa, 4.0 * steps[1] ** 2 / pi)
        super().__init__(shape, steps, reach, 1, springs)
        self.modulus, self.easier = modulus_MPa, easier
        self.radius_mm = float((self.dx * (shape.shape[0] // 2)) ** 2 / (2.0 * shape.max()))
        self.across_mm = np.linspace(-0.5, 0.5, 2 * ACROSS_LINES + 1) * self.dy
        self.maps = tuple(np.zeros((lines, self.across_mm.size)) for lines in (self.near.size, self.far.size))

    def settle(self, load_N: float, layer: Layer) -> None:
        """See how large the area is that touches."""
        pressure, self.approach_mm = self.bodies.press(*self._problem(0.0, load_N, layer))
        self._measure(pressure > 0.0)

    def _area(self, touching: NDArray[np.bool_]) -> float:
        return self.dx * float((2.0 * self.chord_mm)[touching[:, 0]].sum())

    @property
    def chord_mm(self) -> Array:
        """Half of the chord over which each strip (n,) touches, or would."""
        overlap = np.maximum(self.approach_mm - self.shape[:, 0], LEAST_mm)
        return np.asarray(np.minimum(np.sqrt(2.0 * self.radius_mm * overlap), 0.5 * self.dy))

    def spread(self) -> Array:
        """Depth by a strip's mean pressure: the chord is narrower than the cell."""
        return np.asarray(self.dy / (2.0 * self.chord_mm[:, None]))

    @property
    def scars_mm(self) -> tuple[Array, Array]:
        """Worn depths over the lines of either body and those across."""
        near, far = self.maps
        return near, far

    @property
    def _fields(self) -> tuple[Array, ...]:
        return (*super()._fields, *self.maps)

    def _wear(self, depth: Array, rows: slice, weight: float, share: float) -> None:
        super()._wear(depth, rows, weight, share)
        step = self.across_mm[1] - self.across_mm[0]
        inside = np.clip((self.chord_mm[:, None] - np.abs(self.across_mm)) / step + 0.5, 0.0, 1.0)
        near, far = self.maps
        near += (1.0 - share) * depth * inside
        far[rows] += (1.0 - weight) * share * depth * inside
        far[rows.start + 1 : rows.stop + 1] += weight * share * depth * inside

    def lag_mm(self, friction: float, load_N: float) -> float:
        """Elastic displacement under the full friction: a punch of that area."""
        return friction * load_N * self.easier / (2.0 * self.modulus * sqrt(self.area_mm2 / pi))

    def stroke(self, way_mm: Array, half_mm: float, friction: float, load_N: float) -> Array:
        """Friction over its limit along a stroke that begins at a reversal (Masing's rule on Iwan's virgin curve)."""
        lag = self.lag_mm(friction, load_N)
        return np.asarray(2.0 * _virgin(0.5 * way_mm / lag) - _virgin(np.array(half_mm / lag)))


def _virgin(way: Array) -> Array:
    """Force over its limit at a displacement over the mean slider's; limits spread from WEAKEST to 2 − WEAKEST."""
    low, high = WEAKEST, 2.0 - WEAKEST
    slipping = np.clip((way - low) / (high - low), 0.0, 1.0)
    bound = np.clip(way, low, high)
    return np.where(way < low, way, 0.5 * (bound**2 - low**2) / (high - low) + way * (1.0 - slipping))
