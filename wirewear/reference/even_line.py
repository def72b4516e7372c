"""Contact of any even profile, straight or turned about its middle, with a half-space, and its scar in gross slip.

In N, mm, MPa.
"""

import math
from collections.abc import Callable
from functools import cache

import numpy as np

from geometry import Profile
from geometry.arrays import Array
from wirewear.reference.hertz import LineContact, PointContact, require_positive
from wirewear.reference.wear import LineScar

_POINTS, _PLACES = 400, 300
_LEAST = 1e-6


def even_line_load(profile: Profile, half_width_mm: float, modulus_MPa: float) -> float:
    """Load in N/mm under which an even profile h touches over the half-width a.

    P = E* ∫ t h'(t)/√(a² − t²) dt from 0 to a (Johnson, Contact Mechanics, 1985, section 2.7: the profile as a stack of
    flat punches), with t = a sin θ.
    """
    return modulus_MPa * _stacked(profile, half_width_mm, 1)


def turned_load(profile: Profile, radius_mm: float, modulus_MPa: float) -> float:
    """Load in N under which an even profile that is turned about its middle touches over a circle of radius a.

    P = 2 E* ∫ r² h'(r)/√(a² − r²) dr from 0 to a (Sneddon, Int. J. Eng. Sci. 3 (1965) 47).
    """
    return 2.0 * modulus_MPa * _stacked(profile, radius_mm, 2)


def _stacked(profile: Profile, reach_mm: float, power: int) -> float:
    nodes, weights = _rule()
    t = reach_mm * np.sin(0.25 * math.pi * (nodes + 1.0))
    return float(0.25 * math.pi * (weights @ (t**power * _steepness(profile, t))))


def even_line_contact(
    profile: Profile, normal_load_N_per_mm: float, modulus_MPa: float, widest_mm: float
) -> LineContact:
    """Half-width and largest pressure of an even profile under a load, by bisection up to the widest contact.

    p(x) = 1/π ∫ P'(s)/√(s² − x²) ds from |x| to a. Raises ValueError where the widest contact bears less than the load.
    """
    require_positive(normal_load_N_per_mm=normal_load_N_per_mm, modulus_MPa=modulus_MPa, widest_mm=widest_mm)
    half_width, s, gained = _grown(
        lambda a: even_line_load(profile, a, modulus_MPa), normal_load_N_per_mm, widest_mm, "N/mm"
    )
    return LineContact(normal_load_N_per_mm, half_width, _peak(half_width, s, gained / s))


def turned_contact(profile: Profile, normal_load_N: float, modulus_MPa: float, widest_mm: float) -> PointContact:
    """Radius, approach and largest pressure of an even profile that is turned about its middle, under a load.

    The approach is 1/2E* ∫ P'(s)/s ds from 0 to a, p(r) = 1/2π ∫ P'(s)/(s √(s² − r²)) ds from r to a. Raises ValueError
    where the widest contact bears less than the load.
    """
    require_positive(normal_load_N=normal_load_N, modulus_MPa=modulus_MPa, widest_mm=widest_mm)
    radius, s, gained = _grown(lambda a: turned_load(profile, a, modulus_MPa), normal_load_N, widest_mm, "N")
    approach = radius * _stacked(profile, radius, 0)
    return PointContact(normal_load_N, radius, radius, approach, _peak(radius, s, 0.5 * gained / s**2))


def _grown(load_of: Callable[[float], float], load: float, widest_mm: float, unit: str) -> tuple[float, Array, Array]:
    """How far a contact reaches under a load, and places (n,) up to there with the load's gain P' at each."""

    def missing(reach: float) -> float:
        return load_of(reach) - load

    if missing(widest_mm) < 0.0:
        raise ValueError(f"a contact of half-width {widest_mm:g} mm does not bear {load:g} {unit}")
    from scipy.optimize import brentq

    reach = float(brentq(missing, _LEAST * widest_mm, widest_mm, rtol=1e-10))
    s = reach * np.linspace(0.0, 1.0, _PLACES + 1)
    loads = np.array([0.0, *(load_of(float(a)) for a in s[1:])])
    return reach, s[1:], np.gradient(loads, s, edge_order=2)[1:]


def _peak(reach: float, s: Array, per_place: Array) -> float:
    return max(_pressure(x, reach, s, per_place) for x in np.linspace(0.0, 0.99, 100) * reach)


def even_line_scar(profile: Profile, area_mm2: float, widest_mm: float) -> LineScar:
    """Scar of an even profile on a flat in gross slip, both bodies together: A = 2 ∫ (h(b) − h(t)) dt from 0 to b.

    Raises ValueError where the area is larger than the widest scar's.
    """
    require_positive(area_mm2=area_mm2, widest_mm=widest_mm)
    half_width = _scar_reach(profile, area_mm2, widest_mm, lambda t: np.full_like(t, 2.0), "mm²")
    return LineScar(area_mm2, float(_fall(profile, np.array([half_width]))[0]), half_width)


def turned_scar(profile: Profile, volume_mm3: float, widest_mm: float) -> float:
    """Radius in mm of the scar of a profile that is turned about its middle: V = 2π ∫ (h(b) − h(r)) r dr from 0 to b.

    Raises ValueError where the volume is larger than the widest scar's.
    """
    require_positive(volume_mm3=volume_mm3, widest_mm=widest_mm)
    return _scar_reach(profile, volume_mm3, widest_mm, lambda r: 2.0 * math.pi * r, "mm³")


def _scar_reach(profile: Profile, worn: float, widest_mm: float, breadth: Callable[[Array], Array], unit: str) -> float:
    nodes, weights = _rule()

    def missing(reach: float) -> float:
        t = 0.5 * reach * (nodes + 1.0)
        below = _fall(profile, np.array([reach])) - _fall(profile, t)
        return 0.5 * reach * float(weights @ (breadth(t) * below)) - worn

    if missing(widest_mm) < 0.0:
        raise ValueError(f"a scar of half-width {widest_mm:g} mm holds less than {worn:g} {unit}")
    from scipy.optimize import brentq

    return float(brentq(missing, _LEAST * widest_mm, widest_mm, rtol=1e-10))


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
