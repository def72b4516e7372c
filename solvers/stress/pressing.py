"""A hard profile pressed into a half-space without friction, elastic or of metal that flows."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import scipy

from geometry.arrays import Array
from solvers.stress.plastic_zone import Flowed, PlasticZone

_MOST_STEPS = 400
_CLOSED = 1e-7  #: Mean distance of touching surfaces over the approach.


def depth_by_rectangle(along_mm: Array, across_mm: Array, wide_mm: float | Array, high_mm: float | Array) -> Array:
    """Displacement of a half-space's surface, into it, by unit pressure on a rectangle, times π E*, in mm.

    along_mm, across_mm: distances of the point from the rectangle's middle along its sides, which are `wide_mm` and
    `high_mm` long; all are broadcast (Love, Phil. Trans. R. Soc. A 228 (1929) 377).
    """
    depth: Array = np.zeros(np.broadcast_shapes(np.shape(along_mm), np.shape(across_mm)))
    for side in (0.5, -0.5):
        for end in (0.5, -0.5):
            x, y = along_mm + side * wide_mm, across_mm + end * high_mm
            depth += np.sign(side * end) * (x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y)))
    return depth


@dataclass(frozen=True, eq=False)
class Indenter:
    """A hard profile above an elastic surface, on a grid of (n_x, n_y) cells.

    gap_mm: (n_x, n_y), zero where it touches first. step_mm: size (x, y) of a cell. modulus_MPa: E* of both surfaces.
    """

    gap_mm: Array
    step_mm: tuple[float, float]
    modulus_MPa: float

    @property
    def _size(self) -> tuple[int, ...]:
        """Cells of the grid on which convolutions do not come round."""
        return tuple(scipy.fft.next_fast_len(2 * n, real=True) for n in self.gap_mm.shape)

    def displacement(self, pressure: Array) -> Array:
        """Elastic approach (n_x, n_y) in mm of both surfaces at the cells by pressures (n_x, n_y) in MPa."""
        (n_x, n_y), size = pressure.shape, self._size
        spectrum = scipy.fft.rfft2(pressure, s=size)
        spectrum *= _kernel(size, self.step_mm, self.modulus_MPa)
        return np.asarray(scipy.fft.irfft2(spectrum, s=size, overwrite_x=True)[:n_x, :n_y])

    def carried(self, load_N: float, print_mm: Array, guess: Array, tolerance: float = _CLOSED) -> tuple[Array, float]:
        """Pressures (n_x, n_y) in MPa, zero or more, that carry the load, and the approach in mm of the bodies.

        print_mm: (n_x, n_y) depth added to the gap. guess: (n_x, n_y) pressures to start from, of any scale.
        tolerance: mean distance of touching cells over the approach.
        """
        gap, around = self.gap_mm + print_mm, _around(guess)
        pressure = np.zeros_like(gap)
        pressure[around], approach = replace(self, gap_mm=gap[around]).by_gradients(load_N, guess[around], tolerance)
        open_by = self.displacement(pressure) + gap - approach
        open_by[around] = 0.0
        if open_by.min() >= 0.0:
            return pressure, approach
        # They would overlap beyond the cells that were looked at.
        return replace(self, gap_mm=gap).by_gradients(load_N, guess, tolerance)

    def by_gradients(self, load_N: float, guess: Array, tolerance: float) -> tuple[Array, float]:
        """Pressures (n_x, n_y) in MPa, zero or more, that carry the load on this gap, and the approach in mm, by
        conjugate gradients (Polonsky & Keer, Wear 231 (1999) 206). guess, tolerance: as in `carried`.
        """
        gap, mean = self.gap_mm, load_N / (self.step_mm[0] * self.step_mm[1])
        # At first everything touches barely.
        pressure = np.maximum(guess, 1e-12)
        pressure *= mean / pressure.sum()
        direction, old, kept = np.zeros_like(gap), 1.0, 0.0
        for _ in range(_MOST_STEPS):
            open_by = self.displacement(pressure) + gap
            touching = pressure > 0.0
            approach = float(open_by[touching].mean())
            open_by -= approach
            size = float((open_by[touching] ** 2).sum())
            if (pressure * np.abs(open_by)).sum() <= tolerance * mean * abs(approach):
                break
            direction = np.where(touching, open_by + kept * size / old * direction, 0.0)
            old = size
            moved = self.displacement(direction)
            moved -= moved[touching].mean()
            step = (open_by * direction)[touching].sum() / (moved * direction)[touching].sum()
            pressure = np.maximum(pressure - step * direction, 0.0) * touching
            again = (pressure == 0.0) & (open_by < 0.0)
            pressure[again] -= step * open_by[again]
            kept = 0.0 if again.any() else 1.0
            pressure *= mean / pressure.sum()
        return pressure, approach


@lru_cache(maxsize=8)
def _kernel(size: tuple[int, ...], step_mm: tuple[float, float], modulus_MPa: float) -> Array:
    """Spectrum of displacements by unit pressure on a cell, on a grid of this size."""
    along, across = (h * n * scipy.fft.fftfreq(n) for n, h in zip(size, step_mm, strict=True))
    depth = depth_by_rectangle(along[:, None], across, *step_mm)
    return np.asarray(scipy.fft.rfft2(depth / (np.pi * modulus_MPa)))


def _around(pressure: Array) -> tuple[slice, ...]:
    """Rows and columns of the cells under pressure (n_x, n_y), and of a margin around them."""
    found = []
    for axis in (1, 0):
        under = np.flatnonzero((pressure > 0.0).any(axis=axis))
        wide = 2 + (under[-1] - under[0]) // 4
        found.append(slice(max(under[0] - wide, 0), under[-1] + wide + 1))
    return tuple(found)


@dataclass(frozen=True)
class Indentation:
    """A half-space under a profile: state of its metal, load in N, approach of the profile in mm, area of contact."""

    state: Flowed
    load_N: float
    approach_mm: float
    area_mm2: float

    @property
    def pressure_MPa(self) -> Array:
        return np.asarray(-self.state.traction_MPa[..., 2])

    @property
    def print_mm(self) -> float:
        """Largest depth of the surface by plastic strain, which unloading leaves unless metal flows back."""
        return -float(self.state.residual_mm[..., 2].min())

    @property
    def largest_MPa(self) -> float:
        return largest_MPa(self.pressure_MPa)


def largest_MPa(pressure_MPa: Array) -> float:
    """Largest mean over nine cells of pressures (n_x, n_y), since single ones scatter where everything flows."""
    around = np.pad(pressure_MPa, 1)
    return float(np.lib.stride_tricks.sliding_window_view(around, (3, 3)).mean(axis=(2, 3)).max())


def indented(zone: PlasticZone, gap_mm: Array, loads_N: Array) -> Iterator[Indentation]:
    """The half-space under each of the increasing loads in N, one after another, by a hard profile with this gap (n_x,
    n_y) in mm to the unloaded surface. Raises NotConvergedError if the metal cannot bear a load.
    """
    material, cell = zone.space.material, float(np.prod(zone.space.step_mm))
    modulus = material.youngs_modulus_MPa / (1.0 - material.poissons_ratio**2)
    indenter, state = Indenter(gap_mm, zone.space.step_mm, modulus), zone.fresh
    pressure, approach = np.ones_like(gap_mm), 0.0
    for load in loads_N.tolist():

        def traction(residual_mm: Array, load: float = load) -> Array:
            nonlocal pressure, approach
            pressure, approach = indenter.carried(load, -residual_mm[..., 2], pressure)
            return np.stack([np.zeros_like(pressure), np.zeros_like(pressure), -pressure], axis=-1)

        state = zone.loaded(traction, state)
        yield Indentation(state, load, approach, float((pressure > 0.0).sum()) * cell)
