"""Cattaneo–Mindlin partial slip of a line contact under constant normal load (N, mm, MPa; forces per unit length).

Johnson, Contact Mechanics, 1985, sections 7.2 and 7.4. Displacements are left out: those of a loaded half-plane
depend on the point of reference.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Array
from wirewear.reference.hertz import LineContact


def line_stick_ratio(force_N_per_mm: float, limit_N_per_mm: float) -> float:
    """Stick ratio c/a = √(1 − |Q|/µP) on first loading. Raises ValueError beyond µP."""
    unused = 1.0 - abs(force_N_per_mm) / limit_N_per_mm
    if unused < -1e-9:
        raise ValueError(f"the tangential force must not exceed µP = {limit_N_per_mm:g} N/mm")
    return math.sqrt(max(unused, 0.0))


def line_stick_ratio_after_reversal(
    force_N_per_mm: float, reversal_force_N_per_mm: float, limit_N_per_mm: float
) -> float:
    """Inner edge c'/a = √(1 − |Q* − Q|/(2µP)) of the zones that slip back. Raises ValueError outside ±Q*."""
    return line_stick_ratio(0.5 * (reversal_force_N_per_mm - force_N_per_mm), limit_N_per_mm)


def line_loading_traction(contact: LineContact, friction: float, x_mm: ArrayLike, force_N_per_mm: float) -> Array:
    """Return q(x) = µp0[√(1 − x²/a²) − (c/a)√(1 − x²/c²)] in MPa of first loading, odd in Q."""
    a = contact.half_width_mm
    c = a * line_stick_ratio(force_N_per_mm, friction * contact.normal_load_N_per_mm)
    x = np.asarray(x_mm, float)
    shape: Array = (np.sqrt(np.maximum(a**2 - x**2, 0.0)) - np.sqrt(np.maximum(c**2 - x**2, 0.0))) / a
    return math.copysign(friction, force_N_per_mm) * contact.peak_pressure_MPa * shape


def line_traction_after_reversal(
    contact: LineContact, friction: float, x_mm: ArrayLike, force_N_per_mm: float, reversal_force_N_per_mm: float
) -> Array:
    """Traction q(x) after loading to Q* and unloading to Q, q₁(Q*) − 2q₁((Q* − Q)/2), in MPa."""
    change = 0.5 * (reversal_force_N_per_mm - force_N_per_mm)
    first = line_loading_traction(contact, friction, x_mm, reversal_force_N_per_mm)
    return first - 2.0 * line_loading_traction(contact, friction, x_mm, change)
