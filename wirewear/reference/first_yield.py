"""First yield of bodies in contact: the largest contact pressure then, over the yield stress (von Mises)."""

from functools import cache

import numpy as np

#: Excess over a circle's value as a share of a line's, for ratios of the semi-axes; integrated from Boussinesq's
#: stresses for a Poisson's ratio of 0.3, with which it hardly changes.
_RATIOS = (0.0, 0.05, 0.2, 0.4, 0.6, 0.8, 1.0)
_LINE, _CIRCLE = 1.794, 1.613
_SHARES = tuple((ratio - _CIRCLE) / (_LINE - _CIRCLE) for ratio in (_LINE, 1.772, 1.706, 1.653, 1.627, 1.616, _CIRCLE))
_DEPTHS = np.linspace(0.02, 3.0, 3000)  #: Over the minor semi-axis.


def first_yield_ratio(axis_ratio: float, poissons_ratio: float) -> float:
    """p0/σ_y at first yield on the axis below an elliptic Hertz contact without friction.

    axis_ratio: minor over major semi-axis, 0 for a line contact. Stresses on the axis of circle and line are in closed
    form (Johnson, Contact Mechanics (1985), sections 3.4 and 4.2); ellipses are interpolated between.
    """
    circle, line = _circle_and_line(poissons_ratio)
    return circle + float(np.interp(axis_ratio, _RATIOS, _SHARES)) * (line - circle)


@cache
def _circle_and_line(nu: float) -> tuple[float, float]:
    z = _DEPTHS
    pressed = -1.0 / (1.0 + z**2)
    beside = -(1.0 + nu) * (1.0 - z * np.arctan(1.0 / z)) - 0.5 * pressed
    root = np.sqrt(1.0 + z**2)
    along, down = -((1.0 + 2.0 * z**2) / root - 2.0 * z), -1.0 / root
    out = nu * (along + down)
    mises = np.sqrt(0.5 * ((along - down) ** 2 + (down - out) ** 2 + (out - along) ** 2))
    return 1.0 / float(np.abs(pressed - beside).max()), 1.0 / float(mises.max())
