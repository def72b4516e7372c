"""Tangential compliance of a line contact between points inside two half-planes (N, mm, MPa)."""

import numpy as np

from geometry import Elastic
from wirewear.reference.elasticity import require_positive


def half_plane_line_stiffness(
    first: Elastic, second: Elastic, half_width_mm: float, contact_length_mm: float, depth_mm: float = 5.0
) -> float:
    """Initial tangential stiffness in N/mm between two points on the contact's axis, at that depth in each body.

    Full stick, q = Q/(π√(a² − x²)), in plane strain: from the Flamant solution for a tangential line load (Johnson,
    Contact Mechanics, 1985, section 2.3), u(0) = 2(1 − ν²)/(πE)·ln(2/a) at the surface and, averaged over the load,
    u(d) = −[(1 − ν²)/(πE)·ln r² + (1 + ν)/(πE)·d²/r²], r² = d² + x². Bodies narrower than a half-plane are softer.

    Raises ValueError unless all lengths are positive.
    """
    require_positive(half_width_mm=half_width_mm, contact_length_mm=contact_length_mm, depth_mm=depth_mm)
    x = half_width_mm * np.cos(np.pi * (np.arange(400) + 0.5) / 400)
    square = depth_mm**2 + x**2
    logarithm = 2.0 * np.log(2.0 / half_width_mm) + float(np.mean(np.log(square)))
    rotation = float(np.mean(depth_mm**2 / square))
    compliance = sum(
        (1.0 + body.poissons_ratio)
        / (np.pi * body.youngs_modulus_MPa)
        * ((1.0 - body.poissons_ratio) * logarithm + rotation)
        for body in (first, second)
    )
    return float(contact_length_mm / compliance)
