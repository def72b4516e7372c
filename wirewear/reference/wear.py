"""Wear in closed form: scars in gross slip, for round and for any even profiles, and limiting shapes in partial slip.

An even profile is alike on both sides of its middle; a turned one is a surface of revolution about the normal there.
Under partial slip a stick zone in the centre finally carries the whole load, and a worn annulus around it nothing. A
sphere of radius R pressed by d into a half-space of modulus E* and moved to and fro by ±u0 sticks within the radius c
and wears around it until the annulus just touches. By the method of dimensionality reduction the worn shape depends on
d and c alone (Popov, Scientific Reports 4 (2014) 3749; Dimaki, Dmitriev, Chai & Popov, Int. J. Solids Struct. 51 (2014)
4215). Units N, mm, MPa; u0 and d are those of the contact: drive and approach less the deformation of the bodies' bulk.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from math import pi, sqrt

import numpy as np
from numpy.typing import ArrayLike

from geometry import Profile
from geometry.arrays import Array
from wirewear.reference.hertz import LineContact, PointContact, require_positive

_POINTS, _PLACES = 400, 300
_LEAST = 1e-6


@dataclass(frozen=True)
class CrossedWireScar:
    """Round scar of two equal wires crossed at 90°; its depth in the middle and its volume are those of both."""

    volume_mm3: float
    depth_mm: float
    radius_mm: float


@dataclass(frozen=True)
class LineScar:
    """Scar of a cylinder on a flat, a circular segment; its largest depth and area are those of both bodies."""

    area_mm2: float
    depth_mm: float
    half_width_mm: float


def worn_volume(energy_wear_coefficient_mm3_per_J: float, dissipated_energy_mJ: float) -> float:
    """Worn volume V = αE in mm³ (Fouvry et al., Wear 255 (2003) 287)."""
    return energy_wear_coefficient_mm3_per_J * 1e-3 * dissipated_energy_mJ


def crossed_wire_scar(volume_mm3: float, wire_radius_mm: float) -> CrossedWireScar:
    """Scar of equal wires of radius R crossed at 90° after a worn volume V of both, when it is much longer than the
    stroke.

    The wires touch like a sphere of radius R on a flat, so the overlap is a cap: V = πRh², a² = 2Rh. If V grows with
    the number of cycles N, the depth grows as N^½. Raises ValueError for an argument that is not positive.
    """
    require_positive(volume_mm3=volume_mm3, wire_radius_mm=wire_radius_mm)
    depth = math.sqrt(volume_mm3 / (math.pi * wire_radius_mm))
    return CrossedWireScar(volume_mm3, depth, (4.0 * wire_radius_mm * volume_mm3 / math.pi) ** 0.25)


def line_contact_scar(area_mm2: float, radius_mm: float) -> LineScar:
    """Scar of a cylinder of radius R on a flat after a worn area A: A = 2b³/(3R), h = b²/(2R). If A grows with the
    number of cycles N, h grows as N^⅔.

    Raises ValueError for an argument that is not positive.
    """
    require_positive(area_mm2=area_mm2, radius_mm=radius_mm)
    half_width = (1.5 * radius_mm * area_mm2) ** (1.0 / 3.0)
    return LineScar(area_mm2, half_width**2 / (2.0 * radius_mm), half_width)


def worn_pressure(normal_load_N: float, scar: CrossedWireScar) -> float:
    """Uniform pressure P/(πa²) in MPa to which a worn contact tends."""
    return normal_load_N / (math.pi * scar.radius_mm**2)


def explicit_stability_limit(
    mesh_size_mm: float,
    energy_wear_coefficient_mm3_per_J: float,
    friction: float,
    contact_modulus_MPa: float,
    slip_per_update_mm: float,
    *,
    plane: bool = True,
) -> float:
    """Largest stable cycle jump of an explicit wear update, in cycles.

    α is the energy wear coefficient, µ friction, E* the contact modulus, s = slip_per_update_mm the slip of one update.
    A ripple of wave number k changes the pressure by E*k/2 times its height, so one update multiplies it by 1 −
    ΔN·αµs·E*k/2, which must stay above −1: ΔN < 4/(αµs·E*k). The shortest ripple of a line of nodes has k = π/h, with h
    the mesh size (plane=True); the chequered ripple of a square grid has √2 times that (plane=False). Raises ValueError
    for an argument that is not positive.
    """
    require_positive(
        mesh_size_mm=mesh_size_mm,
        energy_wear_coefficient_mm3_per_J=energy_wear_coefficient_mm3_per_J,
        friction=friction,
        contact_modulus_MPa=contact_modulus_MPa,
        slip_per_update_mm=slip_per_update_mm,
    )
    depth_per_pressure = energy_wear_coefficient_mm3_per_J * 1e-3 * friction * slip_per_update_mm
    wave_number = math.pi / mesh_size_mm * (1.0 if plane else math.sqrt(2.0))
    return 4.0 / (depth_per_pressure * contact_modulus_MPa * wave_number)


@dataclass(frozen=True)
class LimitingShape:
    """Shape at which wear has ended in partial slip, of a sphere pressed into a half-space by an approach d until a
    zone of radius c sticks; depths and volume are those of both bodies together.

    Raises ValueError unless all fields are positive and the stick zone lies within the contact, c² < d R.
    """

    sphere_radius_mm: float
    approach_mm: float
    stick_radius_mm: float

    def __post_init__(self) -> None:
        require_positive(
            sphere_radius_mm=self.sphere_radius_mm, approach_mm=self.approach_mm, stick_radius_mm=self.stick_radius_mm
        )
        if self.stick_radius_mm**2 >= self.approach_mm * self.sphere_radius_mm:
            raise ValueError("the stick radius must lie within the contact of the approach")

    def depth(self, radius_mm: ArrayLike) -> Array:
        """Worn depth in mm at distances (mm) from the middle, of their shape; in the stick zone that at its edge, 0."""
        r = np.maximum(np.asarray(radius_mm, float), self.stick_radius_mm)
        return np.maximum(self._opening(r), 0.0)

    @cached_property
    def edge_radius_mm(self) -> float:
        """Outer radius of the worn annulus."""
        from scipy.optimize import brentq

        contact = sqrt(self.approach_mm * self.sphere_radius_mm)
        # The worn annulus ends within this multiple of the contact radius √(dR) unless next to nothing sticks.
        return float(brentq(lambda r: float(self._opening(r)), contact, 100.0 * contact, xtol=1e-15))

    @cached_property
    def volume_mm3(self) -> float:
        from scipy.integrate import quad

        value, _ = quad(
            lambda r: 2.0 * pi * r * float(self.depth(r)), self.stick_radius_mm, self.edge_radius_mm, epsrel=1e-10
        )
        return float(value)

    @cached_property
    def deepest_mm(self) -> tuple[float, float]:
        """The largest depth, and the distance from the middle where it is."""
        radii = np.linspace(self.stick_radius_mm, self.edge_radius_mm, 4001)
        depths = self.depth(radii)
        place = int(np.argmax(depths))
        return float(depths[place]), float(radii[place])

    def load_N(self, modulus_MPa: float) -> float:
        """Load P = 2 E* (d c − c³/(3R)), which the stick zone alone carries; modulus_MPa is E*."""
        c = self.stick_radius_mm
        return 2.0 * modulus_MPa * (self.approach_mm * c - c**3 / (3.0 * self.sphere_radius_mm))

    def slip_mm(self, friction: float, modulus_MPa: float, tangential_modulus_MPa: float) -> float:
        """Amplitude in mm of the bodies' motion at a distance from the contact at which the edge of the stick zone is
        about to slip; modulus_MPa and tangential_modulus_MPa are E* and G*.
        """
        deeper = self.approach_mm - self.stick_radius_mm**2 / self.sphere_radius_mm
        return friction * modulus_MPa / tangential_modulus_MPa * deeper

    def volume_after_slip_mm3(self, slip_mm: float, curvature_per_mm: float) -> float:
        """Worn volume in mm³ for a slip that is not small beside the contact: `volume_mm3` and a term of first order
        in u0.

        slip_mm: u0, amplitude of the motion of points of the bodies far from the contact. curvature_per_mm: curvature
        κ along the motion of the face at which the bodies touch, half the difference of the bodies' curvatures. At an
        end of the stroke the worn annulus, at a distance r beyond the stick radius c from the middle, has slid by s(r)
        = u0 (1 − 2/π arcsin c/r). At x along the motion the face is inclined by κ x, so the side ahead touches until
        the depth s κ x more has worn off there.
        """
        from scipy.integrate import quad

        c = self.stick_radius_mm
        more, _ = quad(lambda r: r**2 * (1.0 - 2.0 / pi * math.asin(c / r)), c, self.edge_radius_mm, epsrel=1e-10)
        return self.volume_mm3 + 4.0 * curvature_per_mm * slip_mm * float(more)

    def pressure(self, radius_mm: ArrayLike, modulus_MPa: float) -> Array:
        """Pressure in MPa at distances (mm) from the middle, of their shape: Hertz's over the stick zone plus a flat
        punch's, infinite at its edge, 0 beyond; modulus_MPa is E*.
        """
        r, c, big = np.asarray(radius_mm, float), self.stick_radius_mm, self.sphere_radius_mm
        root = np.sqrt(np.maximum(c**2 - r**2, 0.0))
        with np.errstate(divide="ignore"):
            punch = (self.approach_mm - c**2 / big) / (pi * root)
        return np.where(r > c, 0.0, modulus_MPa * (2.0 * root / (pi * big) + punch))

    def _opening(self, r: ArrayLike) -> Array:
        r, c, big = np.asarray(r, float), self.stick_radius_mm, self.sphere_radius_mm
        angle = np.arcsin(c / r)
        around = 0.5 * r**2 * angle - 0.5 * c * np.sqrt(np.maximum(r**2 - c**2, 0.0))
        return np.asarray(self.approach_mm - 0.5 * r**2 / big - 2.0 / pi * (self.approach_mm * angle - around / big))


@dataclass(frozen=True)
class WearingContact:
    """A sphere on a half-space that wears where it slips; points of the bodies at a distance are moved by ±drive_mm
    against each other, of which the bodies' bulk takes its share.
    """

    sphere_radius_mm: float
    modulus_MPa: float  #: E*.
    tangential_modulus_MPa: float  #: G*.
    friction: float
    drive_mm: float  #: Amplitude of the prescribed motion.
    bulk_normal_mm_per_N: float = 0.0  #: Normal compliance of the bodies beyond that of half-spaces.
    bulk_tangential_mm_per_N: float = 0.0  #: Tangential compliance beyond it.

    def under_approach(self, approach_mm: float) -> LimitingShape:
        """The limiting shape where the bodies are held pressed by a constant approach, the deformation of their bulk
        included.

        The edge of the stick zone is where it is about to slip: G* u0 = µ E* (d − c²/R). Raises ValueError if nothing
        sticks.
        """
        from scipy.optimize import brentq

        big, modulus, shear = self.sphere_radius_mm, self.modulus_MPa, self.tangential_modulus_MPa

        def pressed(c: float) -> float:
            # d = approach - bulk P(d, c), P linear in d.
            carried = 2.0 * modulus * c
            load_less = carried * c**2 / (3.0 * big)
            bulk = self.bulk_normal_mm_per_N
            return float((approach_mm + bulk * load_less) / (1.0 + bulk * carried))

        def excess(c: float) -> float:
            # The stuck centre moves as a whole: Q = 2 G* c u0.
            u = self.drive_mm / (1.0 + 2.0 * self.bulk_tangential_mm_per_N * shear * c)
            return shear * u - self.friction * modulus * (pressed(c) - c**2 / big)

        contact_mm = sqrt(approach_mm * big)
        smallest = 1e-6 * contact_mm
        if excess(smallest) >= 0.0:
            raise ValueError(f"nothing sticks at a drive of {self.drive_mm:g} mm")
        c = float(brentq(excess, smallest, contact_mm * (1.0 - 1e-12), xtol=1e-15))
        return LimitingShape(big, pressed(c), c)


def worn_under_load(
    sphere_radius_mm: float, modulus_MPa: float, normal_load_N: float, share_of_limit: float
) -> LimitingShape:
    """The limiting shape under a held load P and a held tangential force, `share_of_limit` (0 to 1) of µP; modulus_MPa
    is E*.

    The core stays as large as in the fresh contact (Ciavarella and Hills, Eur. J. Mech. A 18 (1999) 491).
    """
    contact_mm = (0.75 * normal_load_N * sphere_radius_mm / modulus_MPa) ** (1.0 / 3.0)
    c = contact_mm * (1.0 - share_of_limit) ** (1.0 / 3.0)
    approach_mm = normal_load_N / (2.0 * modulus_MPa * c) + c**2 / (3.0 * sphere_radius_mm)
    return LimitingShape(sphere_radius_mm, approach_mm, c)


def even_line_load(profile: Profile, half_width_mm: float, modulus_MPa: float) -> float:
    """Load in N/mm under which an even profile h touches a flat over the half-width a; modulus_MPa is E*.

    P = E* ∫ t h'(t)/√(a² − t²) dt from 0 to a (Johnson, Contact Mechanics, 1985, section 2.7: the profile as a stack of
    flat punches), with t = a sin θ.
    """
    return modulus_MPa * _stacked(profile, half_width_mm, 1)


def turned_load(profile: Profile, radius_mm: float, modulus_MPa: float) -> float:
    """Load in N under which a turned profile h touches a flat over a circle of radius a; modulus_MPa is E*.

    P = 2 E* ∫ r² h'(r)/√(a² − r²) dr from 0 to a (Sneddon, Int. J. Eng. Sci. 3 (1965) 47).
    """
    return 2.0 * modulus_MPa * _stacked(profile, radius_mm, 2)


def _stacked(profile: Profile, reach_mm: float, power: int) -> float:
    nodes, weights = _rule()
    t = reach_mm * np.sin(0.25 * math.pi * (nodes + 1.0))
    steepness = -profile.slope(np.column_stack([t, np.zeros_like(t)]))[:, 0]
    return float(0.25 * math.pi * (weights @ (t**power * steepness)))


def even_line_contact(
    profile: Profile, normal_load_N_per_mm: float, modulus_MPa: float, widest_mm: float
) -> LineContact:
    """The contact of an even profile on a flat under a load: half-width a and largest pressure.

    modulus_MPa: E*. widest_mm: the largest half-width that is tried. With P(s) the load at which the half-width is s
    (`even_line_load`), the pressure at x is 1/π ∫ P'(s)/√(s² − x²) ds from |x| to a. Raises ValueError where the widest
    contact carries less than the load.
    """
    require_positive(normal_load_N_per_mm=normal_load_N_per_mm, modulus_MPa=modulus_MPa, widest_mm=widest_mm)
    half_width, s, gained = _grown(
        lambda a: even_line_load(profile, a, modulus_MPa), normal_load_N_per_mm, widest_mm, "N/mm"
    )
    return LineContact(normal_load_N_per_mm, half_width, _peak(half_width, s, gained / s))


def turned_contact(profile: Profile, normal_load_N: float, modulus_MPa: float, widest_mm: float) -> PointContact:
    """The contact of a turned profile on a flat under a load: radius a, approach and largest pressure.

    modulus_MPa: E*. widest_mm: the largest radius that is tried. With P(s) the load at which the contact's radius is s
    (`turned_load`), the approach is 1/(2E*) ∫ P'(s)/s ds from 0 to a, and the pressure at a distance r from the middle
    is 1/(2π) ∫ P'(s)/(s √(s² − r²)) ds from r to a. Raises ValueError where the widest contact carries less than the
    load.
    """
    require_positive(normal_load_N=normal_load_N, modulus_MPa=modulus_MPa, widest_mm=widest_mm)
    radius, s, gained = _grown(lambda a: turned_load(profile, a, modulus_MPa), normal_load_N, widest_mm, "N")
    approach = radius * _stacked(profile, radius, 0)
    return PointContact(normal_load_N, radius, radius, approach, _peak(radius, s, 0.5 * gained / s**2))


def _grown(load_of: Callable[[float], float], load: float, widest_mm: float, unit: str) -> tuple[float, Array, Array]:
    """Half-width of a contact under a load in mm, places s (n,) up to there, and the load's derivative P'(s) at
    each.
    """

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
    """Scar of an even profile on a flat in gross slip after a worn area A of both bodies: A = 2 ∫ (h(b) − h(t)) dt from
    0 to b; widest_mm: largest half-width b that is tried.

    Raises ValueError where the area is larger than that of the widest scar.
    """
    require_positive(area_mm2=area_mm2, widest_mm=widest_mm)
    half_width = _scar_reach(profile, area_mm2, widest_mm, lambda t: np.full_like(t, 2.0), "mm²")
    return LineScar(area_mm2, float(_fall(profile, np.array([half_width]))[0]), half_width)


def turned_scar(profile: Profile, volume_mm3: float, widest_mm: float) -> float:
    """Radius b in mm of the scar of a turned profile in gross slip after a worn volume V of both bodies: V = 2π ∫ (h(b)
    − h(r)) r dr from 0 to b; widest_mm: largest radius that is tried.

    Raises ValueError where the volume is larger than that of the widest scar.
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
    """Pressure p(x) from P'(s)/s at places s (n,): with s² = x² + u² the integrand has no pole."""
    u = np.linspace(0.0, math.sqrt(half_width**2 - x**2), _PLACES)
    return float(np.trapezoid(np.interp(np.hypot(x, u), s, per_place), u)) / math.pi


@cache
def _rule() -> tuple[Array, Array]:
    """Gauss points on (-1, 1) and their weights, (400,) each, computed on first use."""
    from scipy.special import roots_legendre

    nodes, weights = roots_legendre(_POINTS)
    return nodes, weights


def _fall(profile: Profile, x_mm: Array) -> Array:
    return np.asarray(-profile.height(np.column_stack([x_mm, np.zeros_like(x_mm)])))
