"""An elastic half-space with surface tractions and initial strains, periodic in the plane and layered in depth.

In the plane fields are Fourier series on a regular grid, in depth displacements vary linearly over each layer, whose
strains are those of its middle; below the layers lies the exact half-space. One strain for a layer's thickness leaves
metal that flows at constant volume free to do so.

For a wave vector of length q along e, with t across it and z outwards, displacements are (i U, T, W) exp(i q e.x), and
all equations of U, T and W are real.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from geometry import Elastic
from geometry.arrays import Array, ComplexArray
from solvers.jit_cache import compiled

_FLAT = 1e-6  #: Wave number of the mean over the smallest other one: its limit is that of a single load.


@dataclass(frozen=True, eq=False)
class HalfSpace:
    """An elastic half-space on a grid with l layers.

    shape: odd numbers (n_x, n_y) of points of the grid along x and y; (n, 1) for plane strain, with nothing changing
    along y. step_mm: between points. layers_mm: (l,) thickness of each layer from the surface down.
    """

    material: Elastic
    shape: tuple[int, int]
    step_mm: tuple[float, float]
    layers_mm: Array

    @cached_property
    def depths_mm(self) -> Array:
        """(l,) depth of each layer's middle."""
        return np.asarray(np.cumsum(self.layers_mm) - 0.5 * self.layers_mm)

    @property
    def elastic(self) -> tuple[float, float]:
        return self.material.lame_MPa, self.material.shear_modulus_MPa

    def axes_mm(self) -> tuple[Array, Array]:
        """Coordinates x (n_x,) and y (n_y,) of the grid's points, zero in its middle."""
        along, across = (h * np.arange(-(n // 2), n // 2 + 1.0) for n, h in zip(self.shape, self.step_mm, strict=True))
        return np.asarray(along, dtype=np.float64), np.asarray(across, dtype=np.float64)

    def waves(self, initial_MPa: Array, layers: int | None = None) -> ComplexArray:
        """Displacements (n_x, n_y // 2 + 1, 3 (k + 1)) U, T, W of the levels down to below the upper k `layers` (None:
        all), by stresses (m, n_x, n_y, 6) by which the initial strains of the upper m ≤ k layers would be elastic ones.
        """
        inner = scipy.fft.rfft2(initial_MPa, axes=(1, 2))
        # The mean has no direction.
        inner[:, 0, 0, :2] = 0.5 * (inner[:, 0, 0, :1] + inner[:, 0, 0, 1:2])
        count = len(self.layers_mm) if layers is None else layers
        levels = np.zeros((*self._factor.shape[:2], 3 * (count + 1)), dtype=complex)
        if len(inner):
            _solved(*self._waves, self.layers_mm, self._factor, inner, levels)
        return levels

    def strains(self, waves: ComplexArray, traction_MPa: Array | None) -> Array:
        """Strains (k, n_x, n_y, 6) of tensors in the middles of the upper k layers, by their `waves` and tractions
        (n_x, n_y, 3) on the surface.
        """
        pushed = self._pushed(traction_MPa)
        inner = np.zeros((waves.shape[2] // 3 - 1, *pushed.shape[:2], 6), dtype=complex)
        _spread(*self._waves, self.layers_mm, self._by_traction, waves, pushed, inner)
        return np.asarray(scipy.fft.irfft2(inner, s=self.shape, axes=(1, 2), overwrite_x=True))

    def displacements(self, waves: ComplexArray, traction_MPa: Array | None = None) -> Array:
        """Displacements (n_x, n_y, 3) of the surface in mm, by `waves` and tractions (n_x, n_y, 3)."""
        _, c, s = self._waves
        found = waves[..., :3]
        if traction_MPa is not None:
            found = found + np.einsum("xyij,xyj->xyi", self._by_traction[..., :3, :], self._pushed(traction_MPa))
        along, across, up = np.moveaxis(found, -1, 0)
        surface = np.stack([1j * c * along - s * across, 1j * s * along + c * across, up], axis=-1)
        return np.asarray(scipy.fft.irfft2(surface, s=self.shape, axes=(0, 1)))

    def _pushed(self, traction_MPa: Array | None) -> ComplexArray:
        """Waves (n_x, n_y // 2 + 1, 3) of tractions, as forces on U, T and W of the surface."""
        _, c, s = self._waves
        if traction_MPa is None:
            return np.zeros((*c.shape, 3), dtype=complex)
        along, across, up = np.moveaxis(scipy.fft.rfft2(traction_MPa, axes=(0, 1)), -1, 0)
        return np.stack([-1j * (c * along + s * across), c * across - s * along, up], axis=-1)

    @cached_property
    def _waves(self) -> tuple[Array, Array, Array]:
        """Length and direction's cosine and sine of each wave vector (n_x, n_y // 2 + 1)."""
        along = 2.0 * np.pi * scipy.fft.fftfreq(self.shape[0], self.step_mm[0])
        across = 2.0 * np.pi * scipy.fft.rfftfreq(self.shape[1], self.step_mm[1])
        length = np.hypot(along[:, None], across)
        cosine, sine = np.ones_like(length), np.zeros_like(length)
        np.divide(along[:, None], length, out=cosine, where=length > 0.0)
        np.divide(across, length, out=sine, where=length > 0.0)
        length[0, 0] = _FLAT * along[1]
        return length, cosine, sine

    @cached_property
    def _factor(self) -> Array:
        """Cholesky factors of all waves, banded, from the deepest level up: (n_x, n_y // 2 + 1, 3 (l + 1), 6)."""
        length, _, _ = self._waves
        # Unknowns of two neighbouring levels.
        band = np.zeros((*length.shape, 3 * (len(self.layers_mm) + 1), 6))
        _factorise(length, self.layers_mm, *self.elastic, self.material.poissons_ratio, band)
        return band

    @cached_property
    def _by_traction(self) -> Array:
        """U, T and W of all levels by a unit force on each of the surface, (n_x, n_y // 2 + 1, 3 (l + 1), 3)."""
        found = np.zeros((*self._factor.shape[:3], 3))
        _inverted(self._factor, found)
        return found


@compiled
def _factorise(length: Array, layers: Array, lame: float, shear: float, nu: float, band: Array) -> None:
    """Fill `band` (n_x, n_y, 3 (l + 1), 6), zeros, with the lower Cholesky factor of each wave's stiffness between the
    displacements along the wave, U, across it, T, and downwards, W, of all l + 1 levels: band[..., i, d] stands in row
    i, column i − d, counted from the last unknown of the deepest level, so that only levels with forces take part;
    band[..., 0] is one over the diagonal.

    length: (n_x, n_y) of wave vectors in 1/mm. layers: (l,) thicknesses in mm. lame, shear: Lamé's constants in MPa.
    """
    size = 3 * (len(layers) + 1)
    slope = np.zeros((5, 6))
    law = np.zeros((5, 5))
    law[0, 0] = law[1, 1] = lame + 2.0 * shear
    law[0, 1] = law[1, 0] = lame
    law[2, 2] = law[3, 3] = law[4, 4] = shear
    kappa = 3.0 - 4.0 * nu
    for a in range(length.shape[0]):
        for b in range(length.shape[1]):
            q, own = length[a, b], band[a, b]
            for k in range(len(layers)):
                _slope(slope, q, layers[k])
                stiffness = layers[k] * slope.T @ law @ slope
                for i in range(6):
                    for j in range(i + 1):
                        own[size - 1 - 3 * k - j, i - j] += stiffness[i, j]
            own[2, 0] += shear * q * 4.0 * (1.0 - nu) / kappa
            own[1, 0] += shear * q
            own[0, 0] += shear * q * 4.0 * (1.0 - nu) / kappa
            own[2, 2] += shear * q * 2.0 * (1.0 - 2.0 * nu) / kappa
            _cholesky(own)
            own[:, 0] = 1.0 / own[:, 0]


@compiled
def _cholesky(own: Array) -> None:
    """Change a banded symmetric matrix to its lower factor."""
    for i in range(len(own)):
        for j in range(max(0, i - 5), i + 1):
            total = own[i, i - j]
            for k in range(max(0, i - 5), j):
                total -= own[i, i - k] * own[j, j - k]
            own[i, i - j] = np.sqrt(total) if i == j else total / own[j, 0]


@compiled
def _substituted(own: Array, x: ComplexArray) -> None:
    """Change forces on the upper levels, from the surface down, to their displacements, by the factor.

    T has to do with neither U nor W: of the band, as much is zero as is left out.
    """
    last = len(x) - 3
    first = len(own) - len(x)
    for k in range(0, len(x), 3):
        w, t, u = own[first + k], own[first + k + 1], own[first + k + 2]
        up = last - k
        if k:
            x[up + 2] -= w[1] * x[up + 3] + w[3] * x[up + 5]
            x[up + 1] -= t[3] * x[up + 4]
            x[up] -= u[3] * x[up + 3] + u[5] * x[up + 5]
        x[up + 2] *= w[0]
        x[up + 1] *= t[0]
        x[up] = (x[up] - u[2] * x[up + 2]) * u[0]
    for k in range(0, len(x), 3):
        row = first + last - k
        if k:
            x[k] -= own[row + 3, 1] * x[k - 1] + own[row + 5, 3] * x[k - 3]
            x[k + 1] -= own[row + 4, 3] * x[k - 2]
            x[k + 2] -= own[row + 3, 3] * x[k - 1] + own[row + 5, 5] * x[k - 3]
        x[k] *= own[row + 2, 0]
        x[k + 1] *= own[row + 1, 0]
        x[k + 2] = (x[k + 2] - own[row + 2, 2] * x[k]) * own[row, 0]


@compiled
def _inverted(factor: Array, found: Array) -> None:
    """Set the columns of the inverse for the surface."""
    x = np.zeros(factor.shape[2], dtype=np.complex128)
    for a in range(factor.shape[0]):
        for b in range(factor.shape[1]):
            for c in range(3):
                for i in range(len(x)):
                    x[i] = 1.0 if i == c else 0.0
                _substituted(factor[a, b], x)
                for i in range(len(x)):
                    found[a, b, i, c] = x[i].real


@compiled
def _slope(slope: Array, q: float, thickness: float) -> None:
    """Strains ee, zz and shears ez (over i), et (over i), tz of a layer by U, T, W of its upper and lower level."""
    for side in range(2):
        sign = (1.0 - 2.0 * side) / thickness
        slope[0, 3 * side] = -0.5 * q
        slope[1, 3 * side + 2] = sign
        slope[2, 3 * side] = sign
        slope[2, 3 * side + 2] = 0.5 * q
        slope[3, 3 * side + 1] = 0.5 * q
        slope[4, 3 * side + 1] = sign


@compiled
def _solved(
    length: Array, cosine: Array, sine: Array, layers: Array, factor: Array, inner: ComplexArray, levels: ComplexArray
) -> None:
    """Set U, T and W of the upper levels, which are zero, to those by initial stresses."""
    for a in range(length.shape[0]):
        for b in range(length.shape[1]):
            x = levels[a, b]
            for k in range(len(inner)):
                _push(x[3 * k : 3 * k + 6], inner[k, a, b], length[a, b], layers[k], cosine[a, b], sine[a, b])
            _substituted(factor[a, b], x)


@compiled
def _spread(
    length: Array,
    cosine: Array,
    sine: Array,
    layers: Array,
    by_traction: Array,
    levels: ComplexArray,
    pushed: ComplexArray,
    inner: ComplexArray,
) -> None:
    """Set strains of the upper layers, by levels and forces on the surface."""
    x = np.zeros(levels.shape[2], dtype=np.complex128)
    for a in range(length.shape[0]):
        for b in range(length.shape[1]):
            force, unit = pushed[a, b], by_traction[a, b]
            for i in range(len(x)):
                x[i] = levels[a, b, i] + unit[i, 0] * force[0] + unit[i, 1] * force[1] + unit[i, 2] * force[2]
            for k in range(len(inner)):
                _strained(inner[k, a, b], x[3 * k : 3 * k + 6], length[a, b], layers[k], cosine[a, b], sine[a, b])


@compiled
def _push(x: ComplexArray, t: ComplexArray, q: float, thickness: float, c: float, s: float) -> None:
    """Add the forces on U, T, W of a layer's upper and lower level by its initial stresses in the grid's axes."""
    ee = 0.5 * q * thickness * (c * c * t[0] + s * s * t[1] + 2.0 * c * s * t[3])
    et = -0.5j * q * thickness * (c * s * (t[1] - t[0]) + (c * c - s * s) * t[3])
    ez, tz = -1j * (c * t[5] + s * t[4]), c * t[4] - s * t[5]
    for side in range(2):
        sign = 1.0 - 2.0 * side
        x[3 * side] += sign * ez - ee
        x[3 * side + 1] += sign * tz + et
        x[3 * side + 2] += sign * t[2] + 0.5 * q * thickness * ez


@compiled
def _strained(strain: ComplexArray, x: ComplexArray, q: float, thickness: float, c: float, s: float) -> None:
    """Set strains in the grid's axes, from U, T and W of a layer's upper and lower level."""
    ee, et = -0.5 * q * (x[0] + x[3]), 0.25j * q * (x[1] + x[4])
    ez = 0.5j * ((x[0] - x[3]) / thickness + 0.5 * q * (x[2] + x[5]))
    tz = 0.5 * (x[1] - x[4]) / thickness
    strain[0] = c * c * ee - 2.0 * c * s * et
    strain[1] = s * s * ee + 2.0 * c * s * et
    strain[2] = (x[2] - x[5]) / thickness
    strain[3] = c * s * ee + (c * c - s * s) * et
    strain[4] = s * ez + c * tz
    strain[5] = c * ez - s * tz
