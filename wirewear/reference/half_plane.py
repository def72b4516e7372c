"""Stresses in a half-plane under line contacts: McEwen (1949), sliding (Smith & Liu 1953), partial slip (N, mm, MPa).

The half-plane is z >= 0, z into the body, in plane strain. A pressure acts along +z, a shear traction along +x.
Stresses (..., 6) are in the order xx, yy, zz, xy, yz, xz, tension positive.

Cattaneo–Mindlin partial slip after Johnson (1985), 7.2, 7.4, under constant normal load, in forces per unit length.
Displacements are left out: those of a loaded half-plane depend on the point of reference.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from geometry import Elastic
from geometry.arrays import Array
from wirewear.reference.hertz import LineContact, require_positive


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


def line_stick_shift(contact: LineContact, friction: float, bulk_stress_MPa: float) -> float:
    """Shift e = a σ/(4 µ p0) of the stick zone of like bodies by a bulk tension σ of one, in phase with Q, mm.

    Friction µp0 √(1 − x²/a²) strains the surfaces against each other by 4 (1 − ν²) µp0 x/(aE). What a middle of
    half-width c about e lacks of it, µp0 (c/a) √(1 − (x − e)²/c²), leaves 4 (1 − ν²) µp0 e/(aE) there, which makes up
    for the bulk strain (1 − ν²) σ/E (Nowell & Hills, Int. J. Mech. Sci. 29 (1987) 355; while e + c <= a).
    """
    return float(contact.half_width_mm * bulk_stress_MPa / (4.0 * friction * contact.peak_pressure_MPa))


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


def line_stress(
    x_mm: ArrayLike,
    z_mm: ArrayLike,
    *,
    half_width_mm: float,
    peak_pressure_MPa: float,
    peak_shear_MPa: float = 0.0,
    poissons_ratio: float,
) -> Array:
    """Stresses (..., 6) under p0 √(1 − x²/a²) and a shear q0 √(1 − x²/a²) along +x.

    McEwen, Phil. Mag. 40 (1949) 454 (Johnson, Contact Mechanics, 1985, eqs. 4.49, 7.8). Raises ValueError for a
    half-width that is not positive, or a point above the surface.
    """
    require_positive(half_width_mm=half_width_mm)
    x, z = np.broadcast_arrays(np.asarray(x_mm, float), np.asarray(z_mm, float))
    if np.any(z < 0.0):
        raise ValueError("the half-plane is z_mm >= 0: a point lies above its surface")
    a = half_width_mm
    # m + i n is the root of (a² − (x − i z)²) that decays as the point goes away; n has the sign of x.
    root = np.sqrt((a**2 - x**2 + z**2) + 2j * x * z)
    m, n = root.real, np.where(x < 0.0, -1.0, 1.0) * np.abs(root.imag)
    size = np.maximum(m**2 + n**2, np.finfo(float).tiny)
    ratio = np.where(size > 1e-30 * a**2, (z**2 + n**2) / size, 1.0)
    share = np.where(size > 1e-30 * a**2, (m**2 - z**2) / size, 0.0)
    xx = -(m * (1.0 + ratio) - 2.0 * z) / a
    zz = -m * (1.0 - ratio) / a
    xz = -n * share / a
    shear_xx = (n * (2.0 + share) - 2.0 * x) / a
    p, q = peak_pressure_MPa, peak_shear_MPa
    total_xx, total_zz, total_xz = p * xx + q * shear_xx, p * zz + q * xz, p * xz + q * xx
    none = np.zeros_like(total_xx)
    return np.stack([total_xx, poissons_ratio * (total_xx + total_zz), total_zz, none, none, total_xz], axis=-1)


def line_partial_slip_stress(
    x_mm: ArrayLike,
    z_mm: ArrayLike,
    *,
    half_width_mm: float,
    stick_half_width_mm: float,
    peak_pressure_MPa: float,
    friction: float,
    poissons_ratio: float,
    stick_centre_mm: float = 0.0,
) -> Array:
    """Stresses (..., 6) at first loading in partial slip: sliding on the whole less that on the sticking middle, which
    a bulk stress shifts, see `line_stick_shift`; that stress itself is not in them.

    On the surface, friction adds −2 µ p0 √(x² − c²)/a where it slips and nothing where it sticks (Hills & Nowell,
    Mechanics of Fretting Fatigue, 1994, section 4.2). Raises ValueError for widths that are not positive or a middle
    wider than the contact.
    """
    require_positive(half_width_mm=half_width_mm, stick_half_width_mm=stick_half_width_mm)
    if stick_half_width_mm > half_width_mm:
        raise ValueError(f"the stick half-width {stick_half_width_mm:g} mm exceeds the contact's, {half_width_mm:g} mm")
    shear = friction * peak_pressure_MPa
    whole = line_stress(
        x_mm,
        z_mm,
        half_width_mm=half_width_mm,
        peak_pressure_MPa=peak_pressure_MPa,
        peak_shear_MPa=shear,
        poissons_ratio=poissons_ratio,
    )
    middle = line_stress(
        np.asarray(x_mm, float) - stick_centre_mm,
        z_mm,
        half_width_mm=stick_half_width_mm,
        peak_pressure_MPa=0.0,
        peak_shear_MPa=shear * stick_half_width_mm / half_width_mm,
        poissons_ratio=poissons_ratio,
    )
    return whole - middle
