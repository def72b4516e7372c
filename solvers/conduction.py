"""Temperatures of a surface that is heated in the steady rhythm of many equal cycles.

Each body is a half-space to the heated patch, insulated beside it. A source P exp(i ω t) at a point of the surface
warms the surface at the distance r by P exp(-r √(i ω / κ)) / (2 π k r), with the conductivity k and the diffusivity κ
(Carslaw & Jaeger, Conduction of Heat in Solids, 2nd ed. 1959, ch. X); sources that move are sources at many places in
turn (Jaeger, Proc. R. Soc. NSW 76 (1942) 203).
"""

from dataclasses import dataclass

import numpy as np
import scipy

from geometry.arrays import Array, ComplexArray


@dataclass(frozen=True)
class Conductor:
    """A body that conducts heat: in W/(m K), which is mW/(mm K), J/(cm³ K), and K/W from body to surroundings."""

    conductivity_W_per_m_K: float
    heat_capacity_J_per_cm3_K: float
    resistance_K_per_W: float = 0.0

    @property
    def diffusivity_mm2_per_s(self) -> float:
        return self.conductivity_W_per_m_K / self.heat_capacity_J_per_cm3_K


def surface_rise(heat_mW: Array, cell_mm: float, period_s: float, body: Conductor) -> Array:
    """Rise of the surface's temperature (k, n, m) in K, at k equally spaced moments of a cycle that has gone on long.

    heat_mW: (k, n, m) that flows into each square cell of the surface at these moments. cell_mm: a cell's side.
    """
    count, *shape = heat_mW.shape
    harmonics = np.fft.rfft(heat_mW, axis=0)
    for order, harmonic in enumerate(harmonics):
        harmonics[order] = spread(harmonic, response(order, (shape[0], shape[1]), cell_mm, period_s, body))
    through = 1e-3 * float(heat_mW.sum(axis=(1, 2)).mean()) * body.resistance_K_per_W
    return np.asarray(np.fft.irfft(harmonics, count, axis=0) + through)


def spread(heat_mW: ComplexArray, kernel: ComplexArray) -> ComplexArray:
    """Rises (..., n, m) in K by the heat (..., n, m) of cells and the `response` (..., n', m') to it."""
    n, m = heat_mW.shape[-2:]
    whole = scipy.fft.fft2(heat_mW, s=kernel.shape[-2:]) * kernel
    return np.asarray(scipy.fft.ifft2(whole)[..., :n, :m])


def response(
    order: int, shape: tuple[int, int], cell_mm: float, period_s: float, body: Conductor, length_mm: float = 0.0
) -> ComplexArray:
    """Fourier transform (n', m') of the rise in K by a mW in one of (n, m) cells, in a harmonic of the cycle; without
    the way to the surroundings.

    length_mm: of a line contact whose cells (n, 1) are heated evenly all along it: the rise is the mean over that
    length, by a mW per mm of it. 0: cells are squares.
    """
    decay = np.sqrt(2j * np.pi * order / period_s / body.diffusivity_mm2_per_s)
    padded = [scipy.fft.next_fast_len(2 * size - 1) for size in shape]
    steps = [np.minimum(np.arange(size), size - np.arange(size)) for size in padded]
    distance = cell_mm * np.hypot(steps[0][:, None], steps[1][None, :])
    if length_mm:
        # The mean of a logarithm over a cell is its value at this distance.
        distance[0, 0] = 0.5 * cell_mm / np.e
        rise = _along(distance, decay, length_mm)
    else:
        # A cell warms its own middle as a disc of its area does.
        disc = cell_mm / np.sqrt(np.pi)
        distance[0, 0] = 1.0
        rise = np.exp(-decay * distance) / (2.0 * np.pi * distance)
        rise[0, 0] = (-np.expm1(-decay * disc) / decay if order else disc) / cell_mm**2
    return np.asarray(scipy.fft.fft2(rise) / body.conductivity_W_per_m_K)


def _along(distance: Array, decay: complex, length_mm: float) -> ComplexArray:
    """Mean over a length of the rise at distances (n, m) in mm from a line of that length, which is heated by a unit
    per mm in a body of unit conductivity.
    """
    ends = np.arcsinh(length_mm / distance)
    places, weights = np.polynomial.legendre.leggauss(48)
    along = 0.5 * ends[..., None] * (1.0 + places)
    apart = np.exp(-decay * distance[..., None] * np.cosh(along))
    sources = 1.0 - distance[..., None] / length_mm * np.sinh(along)
    return np.asarray(ends / (2.0 * np.pi) * ((apart * sources) @ weights))
