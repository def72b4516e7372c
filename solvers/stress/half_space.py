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

    def moved(self, traction_MPa: Array | None, initial_MPa: Array | None) -> tuple[Array, Array]:
        """Strains (l, n_x, n_y, 6) of tensors in the middles of layers, and displacements (n_x, n_y, 3) of the surface
        in mm.

        traction_MPa: (n_x, n_y, 3) on the surface. initial_MPa: (l, n_x, n_y, 6) stresses by which the initial strains
        would be elastic ones.
        """
        inner = self.waves(np.zeros((0, *self.shape, 6)) if initial_MPa is None else initial_MPa)
        return self.strains(inner, traction_MPa), self.displacements(inner, traction_MPa)

    def waves(self, initial_MPa: Array) -> ComplexArray:
        """Displacements (n_x, n_y // 2 + 1, 3 (l + 1)) U, T, W of all levels by initial stresses (m, n_x, n_y, 6) of
        the upper m layers, as in `moved`.
        """
        inner = scipy.fft.rfft2(initial_MPa, axes=(1, 2))
        # The mean has no direction.
        inner[:, 0, 0, :2] = 0.5 * (inner[:, 0, 0, :1] + inner[:, 0, 0, 1:2])
        levels = np.zeros(self._factor.shape[:3], dtype=complex)
        if len(inner):
            _solved(*self._waves, self.layers_mm, self._factor, inner, levels)
        return levels

    def strains(self, waves: ComplexArray, traction_MPa: Array | None, layers: int | None = None) -> Array:
        """Strains (m, n_x, n_y, 6) as in `moved` of the upper m `layers` (None: all), by `waves` and tractions."""
        pushed = self._pushed(traction_MPa)
        count = len(self.layers_mm) if layers is None else layers
        inner = np.zeros((count, *pushed.shape[:2], 6), dtype=complex)
        _spread(*self._waves, self.layers_mm, self._by_traction, waves, pushed, inner)
        return np.asarray(scipy.fft.irfft2(inner, s=self.shape, axes=(1, 2), overwrite_x=True))

    def displacements(self, waves: ComplexArray, traction_MPa: Array | None = None) -> Array:
        """Displacements (n_x, n_y, 3) of the surface in mm, as in `moved`, by `waves` and tractions."""
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

    def stresses(self, strain: Array) -> Array:
        """Stresses (..., 6) in MPa by elastic strains (..., 6), tensor components."""
        lame, shear = self.elastic
        result = 2.0 * shear * strain
        result[..., :3] += lame * strain[..., :3].sum(axis=-1, keepdims=True)
        return np.asarray(result)

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
        """Cholesky factors of all waves, banded: (n_x, n_y // 2 + 1, 3 (l + 1), 6)."""
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
    displacements along the wave, U, across it, T, and downwards, W, of all l + 1 levels from the surface down:
    band[..., i, d] stands in row i, column i − d.

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
                        own[3 * k + i, i - j] += stiffness[i, j]
            own[size - 3, 0] += shear * q * 4.0 * (1.0 - nu) / kappa
            own[size - 2, 0] += shear * q
            own[size - 1, 0] += shear * q * 4.0 * (1.0 - nu) / kappa
            own[size - 1, 2] += shear * q * 2.0 * (1.0 - 2.0 * nu) / kappa
            _cholesky(own)


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
    """Change a right-hand side to the solution, by the factor."""
    size = len(own)
    for i in range(size):
        for d in range(1, min(i, 5) + 1):
            x[i] -= own[i, d] * x[i - d]
        x[i] /= own[i, 0]
    for i in range(size - 1, -1, -1):
        for d in range(1, min(size - 1 - i, 5) + 1):
            x[i] -= own[i + d, d] * x[i + d]
        x[i] /= own[i, 0]


@compiled
def _inverted(factor: Array, found: Array) -> None:
    """Set the first three columns of the inverse."""
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
    """Set U, T and W of all levels, which are zero, to those by initial stresses."""
    slope, stress = np.zeros((5, 6)), np.zeros(5, dtype=np.complex128)
    for a in range(length.shape[0]):
        for b in range(length.shape[1]):
            x = levels[a, b]
            for k in range(len(inner)):
                _along_wave(stress, inner[k, a, b], cosine[a, b], sine[a, b])
                _slope(slope, length[a, b], layers[k])
                for i in range(6):
                    for m in range(5):
                        x[3 * k + i] += layers[k] * slope[m, i] * stress[m]
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
    slope, x = np.zeros((5, 6)), np.zeros(levels.shape[2], dtype=np.complex128)
    for a in range(length.shape[0]):
        for b in range(length.shape[1]):
            force, unit = pushed[a, b], by_traction[a, b]
            for i in range(3 * (len(inner) + 1)):
                x[i] = levels[a, b, i] + unit[i, 0] * force[0] + unit[i, 1] * force[1] + unit[i, 2] * force[2]
            for k in range(len(inner)):
                _slope(slope, length[a, b], layers[k])
                _strained(inner[k, a, b], slope, x[3 * k : 3 * k + 6], cosine[a, b], sine[a, b])


@compiled
def _along_wave(stress: ComplexArray, t: ComplexArray, c: float, s: float) -> None:
    """Stresses ee, zz, ez, et, tz as the equations take them, from those in the grid's axes."""
    stress[0] = c * c * t[0] + s * s * t[1] + 2.0 * c * s * t[3]
    stress[1] = t[2]
    stress[2] = -1j * (c * t[5] + s * t[4])
    stress[3] = -1j * (c * s * (t[1] - t[0]) + (c * c - s * s) * t[3])
    stress[4] = c * t[4] - s * t[5]


@compiled
def _strained(strain: ComplexArray, slope: Array, x: ComplexArray, c: float, s: float) -> None:
    """Set strains in the grid's axes, from U, T and W of a layer."""
    own = np.zeros(5, dtype=np.complex128)
    for m in range(5):
        for i in range(6):
            own[m] += slope[m, i] * x[i]
    ee, zz, ez, et, tz = own[0], own[1], 0.5j * own[2], 0.5j * own[3], 0.5 * own[4]
    strain[0] = c * c * ee - 2.0 * c * s * et
    strain[1] = s * s * ee + 2.0 * c * s * et
    strain[2] = zz
    strain[3] = c * s * ee + (c * c - s * s) * et
    strain[4] = s * ez + c * tz
    strain[5] = c * ez - s * tz
