"""Line contact of any even profile with a half-plane, and the scar that gross slip wears into it (N, mm, MPa)."""

import math
from functools import cache

import numpy as np

from geometry import Profile
from geometry.arrays import Array
from wirewear.reference.hertz import LineContact, require_positive
from wirewear.reference.partial_slip_wear import LineScar

_POINTS, _PLACES = 400, 300
_LEAST = 1e-6


def even_line_load(profile: Profile, half_width_mm: float, modulus_MPa: float) -> float:
    """Load in N/mm under which an even profile h touches over the half-width a.

    P = E* ∫ t h'(t)/√(a² − t²) dt from 0 to a (Johnson, Contact Mechanics, 1985, section 2.7: the profile as a stack of
    flat punches), with t = a sin θ.
    """
    nodes, weights = _rule()
    t = half_width_mm * np.sin(0.25 * math.pi * (nodes + 1.0))
    return float(modulus_MPa * 0.25 * math.pi * (weights @ (t * _steepness(profile, t))))


def even_line_contact(
    profile: Profile, normal_load_N_per_mm: float, modulus_MPa: float, widest_mm: float
) -> LineContact:
    """Half-width and largest pressure of an even profile under a load, by bisection up to the widest contact.

    p(x) = 1/π ∫ P'(s)/√(s² − x²) ds from |x| to a. Raises ValueError where the widest contact bears less than the load.
    """
    require_positive(normal_load_N_per_mm=normal_load_N_per_mm, modulus_MPa=modulus_MPa, widest_mm=widest_mm)

    def missing(half_width: float) -> float:
        return even_line_load(profile, half_width, modulus_MPa) - normal_load_N_per_mm

    if missing(widest_mm) < 0.0:
        raise ValueError(f"a contact of half-width {widest_mm:g} mm does not bear {normal_load_N_per_mm:g} N/mm")
    from scipy.optimize import brentq

    half_width = float(brentq(missing, _LEAST * widest_mm, widest_mm, rtol=1e-10))
    s = half_width * np.linspace(0.0, 1.0, _PLACES + 1)
    loads = np.array([0.0, *(even_line_load(profile, float(a), modulus_MPa) for a in s[1:])])
    per_place = np.gradient(loads, s, edge_order=2)[1:] / s[1:]
    peak = max(_pressure(x, half_width, s[1:], per_place) for x in np.linspace(0.0, 0.99, 100) * half_width)
    return LineContact(normal_load_N_per_mm, half_width, peak)


def even_line_scar(profile: Profile, area_mm2: float, widest_mm: float) -> LineScar:
    """Scar of an even profile on a flat in gross slip, both bodies together: A = 2 ∫ (h(b) − h(t)) dt from 0 to b.

    Raises ValueError where the area is larger than the widest scar's.
    """
    require_positive(area_mm2=area_mm2, widest_mm=widest_mm)

    nodes, weights = _rule()

    def missing(half_width: float) -> float:
        t = 0.5 * half_width * (nodes + 1.0)
        mean = float(weights @ (_fall(profile, np.array([half_width])) - _fall(profile, t))) * 0.5
        return 2.0 * half_width * mean - area_mm2

    if missing(widest_mm) < 0.0:
        raise ValueError(f"a scar of half-width {widest_mm:g} mm holds less than {area_mm2:g} mm²")
    from scipy.optimize import brentq

    half_width = float(brentq(missing, _LEAST * widest_mm, widest_mm, rtol=1e-10))
    return LineScar(area_mm2, float(_fall(profile, np.array([half_width]))[0]), half_width)


def _pressure(x: float, half_width: float, s: Array, per_place: Array) -> float:
    """p(x) from P'(s)/s at places s: with s² = x² + u² the integrand has no pole."""
    u = np.linspace(0.0, math.sqrt(half_width**2 - x**2), _PLACES)
    return float(np.trapezoid(np.interp(np.hypot(x, u), s, per_place), u)) / math.pi


@cache
def _rule() -> tuple[Array, Array]:
    """Gauss points on -1 to 1 and their weights, (400,) each, when they are first asked for."""
    from scipy.special import roots_legendre

    nodes, weights = roots_legendre(_POINTS)
    return nodes, weights


def _fall(profile: Profile, x_mm: Array) -> Array:
    return np.asarray(-profile.height(np.column_stack([x_mm, np.zeros_like(x_mm)])))


def _steepness(profile: Profile, x_mm: Array) -> Array:
    return np.asarray(-profile.slope(np.column_stack([x_mm, np.zeros_like(x_mm)]))[:, 0])
