"""Simulator 1, for scoring alone: crossed wires as two elastic half-spaces, by boundary elements.

Displacements of evenly loaded rectangles: Love, Phil. Trans. A 228 (1929) 377. Conjugate gradients under a given load:
Polonsky & Keer, Wear 231 (1999) 206, with convolutions as products of their transforms.
"""

from math import pi

import numpy as np
from scipy import fft

from studies.blind.generators.other_simulators.pair import Array, Layer, StickingPair

#: Change of all pressures at which a solution is found, where forces are wanted and where bodies wear.
FINE, COARSE, MOST_ITERATIONS = 1e-6, 1e-4, 300
FEWEST = 4  #: Fewest cells that touch; with fewer, all that overlap touch again.


class HalfSpaces:
    """Two half-spaces of a combined modulus on a grid of rectangles."""

    def __init__(self, shape: tuple[int, int], steps_mm: tuple[float, float], modulus_MPa: float) -> None:
        """Nothing is worn yet."""
        self.shape, self.cell = shape, steps_mm[0] * steps_mm[1]
        self.padded = (fft.next_fast_len(2 * shape[0] - 1, real=True), fft.next_fast_len(2 * shape[1] - 1, real=True))
        x, y = (
            step * ((np.arange(size) + size // 2) % size - size // 2)
            for step, size in zip(steps_mm, self.padded, strict=True)
        )
        a, b = 0.5 * steps_mm[0], 0.5 * steps_mm[1]
        corners = [sx * sy * _corner(x[:, None] + sx * a, y[None] + sy * b) for sx in (1.0, -1.0) for sy in (1.0, -1.0)]
        self.kernel = fft.rfft2(sum(corners) / (pi * modulus_MPa))
        self.pressure, self.tolerance = np.zeros(shape), FINE

    def give(self, pressure: Array, local: Array | float) -> Array:
        """Displacement of both surfaces together, local compliance included [mm]."""
        spread = fft.irfft2(self.kernel * fft.rfft2(pressure, self.padded), self.padded)
        return np.asarray(spread[: self.shape[0], : self.shape[1]] + local * pressure)

    def press(self, gap_mm: Array, load_N: float, local: Array | float) -> tuple[Array, float]:
        """Pressures under a load and the approach; begins from the last solution."""
        total = load_N / self.cell
        guess = self.pressure if self.pressure.any() else np.where(gap_mm <= np.quantile(gap_mm, 0.05), 1.0, 0.0)
        pressure = guess * (total / guess.sum())
        along, last, keep, approach = np.zeros_like(gap_mm), 1.0, 0.0, 0.0
        for _ in range(MOST_ITERATIONS):
            gap = gap_mm + self.give(pressure, local)
            touching = pressure > 0.0
            approach = float(gap[touching].mean())
            gap -= approach
            if touching.sum() < FEWEST:
                overlapping = gap <= np.sort(gap, axis=None)[2 * FEWEST]
                pressure, keep = overlapping * (total / overlapping.sum()), 0.0
                continue
            size = float((gap[touching] ** 2).sum())
            if size == 0.0:
                break
            along = np.where(touching, gap + keep * size / last * along, 0.0)
            last = size
            turned = self.give(along, local)
            turned -= turned[touching].mean()
            step = float((gap * along)[touching].sum() / (turned * along)[touching].sum())
            new = np.maximum(pressure - step * along, 0.0) * touching
            overlapping = ~touching & (gap < 0.0) | (touching & (new == 0.0) & (gap < 0.0))
            new = np.where(overlapping, new - step * gap, new)
            keep = 0.0 if overlapping.any() else 1.0
            new *= total / new.sum()
            change, pressure = float(np.abs(new - pressure).sum()) / total, new
            if change < self.tolerance:
                break
        self.pressure = pressure
        return pressure, approach


def _corner(x: Array, y: Array) -> Array:
    return np.asarray(x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y)))


class HalfSpaceWires(StickingPair):
    """Crossed wires that stick and slip as Mindlin's bodies do."""

    def __init__(
        self, shape: Array, steps: tuple[float, float], reach: float, modulus_MPa: float, easier: float
    ) -> None:
        """Nothing is worn yet."""
        self.spaces = HalfSpaces((shape.shape[0], shape.shape[1]), steps, modulus_MPa)
        super().__init__(shape, steps, reach, 1, self.spaces)
        self.sheared, self.easier = self.spaces, easier

    def sweep(self, load_N: float, half_slip_mm: float, depth_per_MPa: float, share: float, layer: Layer) -> None:
        """Wear along one stroke; what is left of a coarse solution's errors wears away."""
        self.spaces.tolerance = COARSE
        super().sweep(load_N, half_slip_mm, depth_per_MPa, share, layer)
        self.spaces.tolerance = FINE
