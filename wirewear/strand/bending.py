"""From stick to slip: how layers of a strand slide under tension and friction as it is bent (N, mm, rad).

Papailiou (IEEE Trans. Power Delivery 12 (1997) 1576): a member (wire or strand of a layer) sticks until its tension
grows along it by more than radial pressure and friction allow. It slips first at the neutral axis, at last at the
extrados, the outer side. Reversals follow Masing's rule to first order in µ sin α, so that the amplitude of curvature
can be used in place of a first bend.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np

from geometry.arrays import Array
from wirewear.strand.helix import Helix

_PLACES = 401  #: From the neutral axis to the extrados.
ANGLES = np.linspace(0.0, 0.5 * pi, _PLACES)


@dataclass(frozen=True, eq=False)
class MemberSlip:
    """How one member of a layer, of axial stiffness EA, slips as the strand is bent. gain_N: its tension above the mean
    at ANGLES, from the neutral axis to the extrados, if it slips everywhere.
    """

    helix: Helix
    stiffness_N: float
    gain_N: Array

    @property
    def _lever_N_mm(self) -> float:
        """Change of tension per curvature in N mm of a member that sticks: EA r cos²α."""
        return self.stiffness_N * self.helix.radius_mm * cos(self.helix.angle_rad) ** 2

    @property
    def _ratio(self) -> Array:
        """Curvature in 1/mm at which the slip zone, which grows from the neutral axis, has reached each of ANGLES."""
        first = self.gain_N[1] / ANGLES[1] * 2.0 - self.gain_N[2] / ANGLES[2]
        return np.concatenate([[first], self.gain_N[1:] / np.sin(ANGLES[1:])]) / self._lever_N_mm

    @property
    def first_per_mm(self) -> float:
        """Curvature in 1/mm at which slip begins, at the neutral axis."""
        return float(self._ratio[0])

    def slip_mm(self, curvature_per_mm: float) -> float:
        """Slip along the member at the neutral axis when the strand is bent to this curvature; 0 while it sticks."""
        reached = float(np.interp(curvature_per_mm, self._ratio, ANGLES))
        if curvature_per_mm <= self.first_per_mm:
            return 0.0
        angles = np.append(ANGLES[reached > ANGLES], reached)
        held = float(np.trapezoid(np.interp(angles, ANGLES, self.gain_N), angles)) / self.stiffness_N
        free = self._lever_N_mm / self.stiffness_N * curvature_per_mm * (1.0 - cos(reached))
        return self.helix.radius_mm / sin(self.helix.angle_rad) * (free - held)

    def gained_N(self, curvature_per_mm: float) -> float:
        """Tension above the mean at the extrados at this curvature: that of a sticking member, limited by friction."""
        return min(self._lever_N_mm * curvature_per_mm, float(self.gain_N[-1]))


@dataclass(frozen=True)
class BentLayer:
    """A layer of a bent strand: its helix, number of members, and tension and axial stiffness EA of each."""

    helix: Helix
    count: int
    tension_N: float
    stiffness_N: float


def member_slips(
    layers: Sequence[BentLayer], friction: float, outside_N_per_mm: float, presses: Sequence[float]
) -> list[MemberSlip]:
    """How each layer slips, from the innermost to the outermost.

    outside_N_per_mm: radial load on the outermost layer per mm of the strand's axis. presses: share of each layer's
    radial load that it passes to the layer below, 0 for one that arches. A member is held below by its own radial
    pressure and that of the layers above, and above by the latter. Layers above are taken to have slipped already
    (Papailiou); an arching layer is held by its neighbours as by a core.
    """
    found: list[MemberSlip] = []
    above = np.full(_PLACES, outside_N_per_mm)
    for layer, passes_on in zip(reversed(layers), reversed(presses), strict=True):
        alpha, radius = layer.helix.angle_rad, layer.helix.radius_mm
        m = friction * sin(alpha)
        outer = above * cos(alpha) / layer.count * radius / sin(alpha) ** 2
        # dT/dφ = m (T + 2 P) on the way from the neutral axis.
        decayed = np.exp(-m * ANGLES) * 2.0 * m * outer
        steps = 0.5 * (decayed[1:] + decayed[:-1]) * ANGLES[1]
        tension = np.exp(m * ANGLES) * (layer.tension_N + np.concatenate([[0.0], np.cumsum(steps)]))
        found.append(MemberSlip(layer.helix, layer.stiffness_N, tension - layer.tension_N))
        own = layer.count * tension * layer.helix.curvature_per_mm / cos(alpha)
        above = passes_on * (own + above)
    return found[::-1]


def relative_slip_mm(outer: Helix | None, outer_mm: float, inner: Helix | None, inner_mm: float) -> tuple[float, float]:
    """(along the strand's axis, around it): slip of an outer member against an inner one at the neutral axis.

    Each slides along itself by outer_mm or inner_mm; with opposite lays both add up along the axis. A helix of None is
    a straight core, which does not slide.
    """
    parts = [(h, u) for h, u in ((outer, outer_mm), (inner, -inner_mm)) if h is not None]
    return (sum(h.hand * u * cos(h.angle_rad) for h, u in parts), sum(u * sin(h.angle_rad) for h, u in parts))
