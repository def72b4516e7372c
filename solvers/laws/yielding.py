"""Bodies that yield: the largest pressure that a contact bears, and the permanent print where it would exceed it.

Under a contact that has yielded, plastic strain displaces metal until the pressure is spread: seen from the surface, no
pressure exceeds a limit H, and there the surfaces close permanently; the depth of this is the print. H grows slowly
with the load P, from the largest pressure at first yield, C sigma_y, because the elastic metal around constrains it:

    H = sigma_y min(C + 0.205 ln(P/P_y), 2.95)    for P > P_y, the load at first yield of the unworn bodies,

fitted to the largest pressures of finite elements for spheres (J2, perfectly plastic) at P/P_y of 1.2, 1.7, 4.1, 8.7,
12, 27, 58 and 1290: 1.67, 1.77, 1.98, 2.06, 2.14, 2.30, 2.48 and 2.95 times sigma_y. Unloading and reloading are
elastic.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Array, IntArray

_GROWTH, _LARGEST = 0.205, 2.95  #: Growth with ln(P/P_y) and largest value of H / sigma_y, see above.
#: The limit rises by this share where the print is as deep as Hertz' approach, which keeps the equations regular.
_RISE = 0.005
#: Strain of an indentation is 0.2 a/R (Tabor, The Hardness of Metals (1951)); the contact's radius a grows about with
#: this power of the load, between Hertz' 1/3 and full plasticity's 1/2.
_SPREADING = 0.4


@dataclass(frozen=True)
class YieldAtNodes:
    """At k paired nodes: the pressure limit (k,) in MPa, and its rise (k,) per mm of print in the current increment."""

    limit: Array
    rise_MPa_per_mm: Array

    def among(self, nodes: IntArray) -> "YieldAtNodes":
        """The limits at the nodes of these indices into the k."""
        return YieldAtNodes(self.limit[nodes], self.rise_MPa_per_mm[nodes])

    def closure(self, pressure: Array) -> tuple[Array, Array]:
        """Permanent closure (k,) in mm by pressures (k,) in MPa, 0 up to the limit, and its derivative by pressure."""
        beyond = pressure - self.limit
        softness = (beyond > 0.0) / self.rise_MPa_per_mm
        return beyond * softness, softness

    def work(self, pressure: Array) -> Array:
        """Plastic work (k,) per plane area in mJ/mm² under pressures (k,) in MPa."""
        return np.asarray(0.5 * (self.limit + pressure) * self.closure(pressure)[0])


@dataclass(frozen=True)
class PressureLimit:
    """The pressure limit of two bodies in contact, from the softer one.

    first_yield_ratio: C, the largest pressure at first yield over the yield stress. first_yield_load: the load P_y of
    the unworn bodies at first yield, in N, for a line contact in N/mm.
    """

    yield_stress_MPa: float
    first_yield_ratio: float
    first_yield_load: float
    overlap_mm: float  #: Hertz' approach under the test's load, over which the limit rises.
    upper_share: float = 0.5  #: Share of the print on the upper body: 0 if it is the harder one.
    hardening_MPa: float = 0.0  #: Rise of the yield stress per plastic strain.
    first_yield_strain: float = 0.0  #: Strain 0.2 a/R of the indentation at first yield.
    share_borne: float = 1.0  #: Factor of the limit of spheres that these bodies bear.
    printed_load: float = 0.0  #: Load whose prints surfaces have from the outset: below it the limit is that load's.

    def share(self, *, upper: bool) -> float:
        return self.upper_share if upper else 1.0 - self.upper_share

    def limit_MPa(self, load: ArrayLike) -> Array:
        """Pressure limit H in MPa under loads in N (line contacts N/mm), of the loads' shape."""
        beyond = np.maximum(np.asarray(load) / self.first_yield_load, 1.0)
        plastic = self.first_yield_strain * (beyond**_SPREADING - 1.0)
        ratio = np.minimum(self.first_yield_ratio + _GROWTH * np.log(beyond), max(_LARGEST, self.first_yield_ratio))
        return np.asarray(self.share_borne * ratio * (self.yield_stress_MPa + self.hardening_MPa * plastic))

    def at_nodes(self, load: ArrayLike, printed_mm: Array) -> YieldAtNodes:
        """The limits at k nodes under a load in N, one or (k,), with the prints `printed_mm` (k,) that both bodies
        together have already.
        """
        limit = self.limit_MPa(np.maximum(load, self.printed_load))
        rise = np.full_like(printed_mm, _RISE * limit / self.overlap_mm)
        return YieldAtNodes(limit + rise * printed_mm, rise)

    def borne_MPa(self, largest_MPa: float, load: float, printed_mm: float) -> "PressureLimit":
        """This limit for bodies that already have prints, of both together printed_mm deep, from a load (as in
        `limit_MPa`) under which they bear largest_MPa there.
        """
        unrisen = largest_MPa / (1.0 + _RISE * printed_mm / self.overlap_mm)
        # Loads that effects change by round-off are no larger ones.
        return replace(self, share_borne=unrisen / float(self.limit_MPa(load)), printed_load=load * (1.0 + 1e-6))
