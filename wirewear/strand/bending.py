"""From stick to slip: how layers of a strand slide under tension and friction as the strand is bent (N, mm, rad).

Papailiou (IEEE Trans. Power Delivery 12 (1997) 1576): a wire sticks until the gain of its tension along it exceeds the
friction that radial pressure allows. It slips first at the neutral axis, then up to the extrados. Reversals follow
Masing's rule to first order in µ sin α, so that an amplitude of curvature takes the place of a first bend.
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
class SlipCourse:
    """One member of a layer, a wire or a strand; gain (ANGLES): tension over its mean one where all of it slips."""

    helix: Helix
    stiffness_N: float  #: EA.
    gain_N: Array

    @property
    def _lever_N_mm(self) -> float:
        """Change of tension per curvature of a member that sticks: EA r cos²α."""
        return self.stiffness_N * self.helix.radius_mm * cos(self.helix.angle_rad) ** 2

    @property
    def _ratio(self) -> Array:
        """Curvature at which slip has come as far as each of ANGLES."""
        first = self.gain_N[1] / ANGLES[1] * 2.0 - self.gain_N[2] / ANGLES[2]
        return np.concatenate([[first], self.gain_N[1:] / np.sin(ANGLES[1:])]) / self._lever_N_mm

    @property
    def first_per_mm(self) -> float:
        """Curvature at which slip begins at the neutral axis."""
        return float(self._ratio[0])

    @property
    def full_per_mm(self) -> float:
        """Curvature from which on all of the member slips."""
        return float(self._ratio[-1])

    def slip_mm(self, curvature_per_mm: float) -> float:
        """Slip along the member at the neutral axis, 0 while it sticks."""
        reached = float(np.interp(curvature_per_mm, self._ratio, ANGLES))
        if curvature_per_mm <= self.first_per_mm:
            return 0.0
        angles = np.append(ANGLES[reached > ANGLES], reached)
        held = float(np.trapezoid(np.interp(angles, ANGLES, self.gain_N), angles)) / self.stiffness_N
        free = self._lever_N_mm / self.stiffness_N * curvature_per_mm * (1.0 - cos(reached))
        return self.helix.radius_mm / sin(self.helix.angle_rad) * (free - held)

    def gained_N(self, curvature_per_mm: float) -> float:
        """Tension over the mean one at the extrados: that of a member that sticks, up to what friction allows."""
        return min(self._lever_N_mm * curvature_per_mm, float(self.gain_N[-1]))


@dataclass(frozen=True)
class BentLayer:
    """What the slip of a layer depends on: its helix, number, tension and stiffness of each member."""

    helix: Helix
    count: int
    tension_N: float
    stiffness_N: float


def slip_courses(
    layers: Sequence[BentLayer], friction: float, outside_N_per_mm: float, presses: Sequence[float]
) -> list[SlipCourse]:
    """Slip of each layer, from the innermost on, under what presses on the outermost per millimetre of the axis.

    presses: the part of each layer's load that presses on the one below, 0 of one that arches.
    A member is held below by its own radial pressure and that of layers above, above by the latter. Those have slipped
    when it does, as Papailiou has it, and arches are held by their neighbours as a layer is by its core.
    """
    found: list[SlipCourse] = []
    above = np.full(_PLACES, outside_N_per_mm)
    for layer, passes_on in zip(reversed(layers), reversed(presses), strict=True):
        alpha, radius = layer.helix.angle_rad, layer.helix.radius_mm
        m = friction * sin(alpha)
        outer = above * cos(alpha) / layer.count * radius / sin(alpha) ** 2
        # dT/dφ = m (T + 2 P) on the way from the neutral axis.
        decayed = np.exp(-m * ANGLES) * 2.0 * m * outer
        steps = 0.5 * (decayed[1:] + decayed[:-1]) * ANGLES[1]
        tension = np.exp(m * ANGLES) * (layer.tension_N + np.concatenate([[0.0], np.cumsum(steps)]))
        found.append(SlipCourse(layer.helix, layer.stiffness_N, tension - layer.tension_N))
        own = layer.count * tension * layer.helix.curvature_per_mm / cos(alpha)
        above = passes_on * (own + above)
    return found[::-1]


def relative_slip_mm(outer: Helix | None, outer_mm: float, inner: Helix | None, inner_mm: float) -> tuple[float, float]:
    """Slip of an outer against an inner member at the neutral axis, along the strand's axis and around it.

    Each slides along itself; those of opposite lay to opposite sides, so that along the axis both add up. None: a
    straight core, which does not slide.
    """
    parts = [(h, u) for h, u in ((outer, outer_mm), (inner, -inner_mm)) if h is not None]
    return (sum(h.hand * u * cos(h.angle_rad) for h, u in parts), sum(u * sin(h.angle_rad) for h, u in parts))
