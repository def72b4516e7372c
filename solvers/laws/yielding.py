"""Bodies that yield: the pressure that a contact bears, and the gap that stays where it would have to bear more.

Under a contact that has yielded, plastic strain pushes metal aside until the pressure is spread: seen from the surface,
no pressure exceeds a limit H, and surfaces close there for good. H grows slowly with the load, from the largest
pressure at first yield, C sigma_y, by constraint of the elastic metal around:

    H = sigma_y min(C + 0.205 ln(P/P_y), 2.95)    for P > P_y, the load at first yield of the unworn bodies,

the largest pressures of finite elements for spheres (J2, perfectly plastic) at P/P_y of 1.2, 1.7, 4.1, 8.7, 12, 27, 58
and 1290: 1.67, 1.77, 1.98, 2.06, 2.14, 2.30, 2.48 and 2.95 times sigma_y. Unloading and loading again are elastic.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Array, IntArray

_GROWTH, _LARGEST = 0.205, 2.95  #: Of the limit over the yield stress, see above.
#: Strain of an indentation is 0.2 a/R (Tabor, The Hardness of Metals (1951)); the contact's radius a grows about with
#: this power of the load, between Hertz' 1/3 and full plasticity's 1/2.
_SPREADING = 0.4
#: Share of the limit by which it rises where the print is as deep as Hertz' approach: what keeps the equations regular.
_REGULAR = 0.005


@dataclass(frozen=True)
class YieldAtNodes:
    """At k paired nodes, what they bear before they yield, MPa, and how much more for each mm of print, (k,) both."""

    limit: Array
    rise_MPa_per_mm: Array

    def among(self, nodes: IntArray) -> "YieldAtNodes":
        """What some of the nodes bear."""
        return YieldAtNodes(self.limit[nodes], self.rise_MPa_per_mm[nodes])

    def closure(self, pressure: Array) -> tuple[Array, Array]:
        """By how much (k,) surfaces yield under pressures (k,), mm, and its derivative."""
        beyond = pressure - self.limit
        softness = np.where(beyond > 0.0, 1.0 / self.rise_MPa_per_mm, 0.0)
        return beyond * softness, softness

    def work(self, pressure: Array) -> Array:
        """Plastic work (k,) per plane area of surfaces that yield under pressures (k,), mJ/mm²."""
        return np.asarray(0.5 * (self.limit + pressure) * self.closure(pressure)[0])


@dataclass(frozen=True)
class PressureLimit:
    """What the softer of two bodies bears: its yield stress, the largest pressure over it at first yield, and the load
    of that for the unworn bodies, in N, of a line contact N/mm.
    """

    yield_stress_MPa: float
    first_yield_ratio: float
    first_yield_load: float
    overlap_mm: float  #: Hertz' approach under the test's load, a measure of depths.
    upper_share: float = 0.5  #: Of the print, that the upper body takes: none where it is the harder.
    hardening_MPa: float = 0.0  #: Rise of the yield stress per plastic strain.
    first_yield_strain: float = 0.0  #: Strain 0.2 a/R of the indentation at first yield.

    def share(self, *, upper: bool) -> float:
        """Share of a print that the upper or the lower body takes."""
        return self.upper_share if upper else 1.0 - self.upper_share

    def limit_MPa(self, load: ArrayLike) -> Array:
        """Largest pressure under loads, of their shape."""
        beyond = np.maximum(np.asarray(load) / self.first_yield_load, 1.0)
        plastic = self.first_yield_strain * (beyond**_SPREADING - 1.0)
        ratio = np.minimum(self.first_yield_ratio + _GROWTH * np.log(beyond), max(_LARGEST, self.first_yield_ratio))
        return np.asarray(ratio * (self.yield_stress_MPa + self.hardening_MPa * plastic))

    def strain(self, load: float) -> float:
        """Strain 0.2 a/R of the indentation under a load."""
        return float(self.first_yield_strain * max(load / self.first_yield_load, 0.0) ** _SPREADING)

    def at_nodes(self, load: ArrayLike, printed_mm: Array) -> YieldAtNodes:
        """The limit at nodes under a load, or one for each, where both bodies together have a print (k,)."""
        limit = self.limit_MPa(load)
        rise = np.broadcast_to(_REGULAR * limit / self.overlap_mm, printed_mm.shape)
        return YieldAtNodes(limit + rise * printed_mm, rise)
