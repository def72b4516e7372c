"""Temperatures of a surface that is heated in the steady rhythm of many equal cycles.

Each body is a half-space to the heated patch, insulated beside it. A source P exp(i ω t) at a point of the surface
warms the surface at the distance r by P exp(-r √(i ω / κ)) / (2 π k r), with the conductivity k and the diffusivity κ
(Carslaw & Jaeger, Conduction of Heat in Solids, 2nd ed. 1959, ch. X); sources that move are sources at many places in
turn (Jaeger, Proc. R. Soc. NSW 76 (1942) 203).
"""

from dataclasses import dataclass

import numpy as np
from scipy import fft

from geometry.arrays import Array


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
    padded = [fft.next_fast_len(2 * size - 1) for size in shape]
    steps = [np.minimum(np.arange(size), size - np.arange(size)) for size in padded]
    distance = cell_mm * np.hypot(steps[0][:, None], steps[1][None, :])
    # A cell warms its own middle as a disc of its area does.
    disc = cell_mm / np.sqrt(np.pi)
    distance[0, 0] = 1.0
    harmonics = np.fft.rfft(heat_mW, axis=0)
    for order, harmonic in enumerate(harmonics):
        decay = np.sqrt(2j * np.pi * order / period_s / body.diffusivity_mm2_per_s)
        response = np.exp(-decay * distance) / (2.0 * np.pi * distance)
        response[0, 0] = (-np.expm1(-decay * disc) / decay if order else disc) / cell_mm**2
        spread = fft.ifft2(fft.fft2(harmonic, s=padded) * fft.fft2(response))[: shape[0], : shape[1]]
        harmonics[order] = spread / body.conductivity_W_per_m_K
    through = 1e-3 * float(heat_mW.sum(axis=(1, 2)).mean()) * body.resistance_K_per_W
    return np.asarray(np.fft.irfft(harmonics, count, axis=0) + through)
