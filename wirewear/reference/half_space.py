"""Stresses in a half-space under round contacts and in a half-plane under line contacts (N, mm, MPa).

The body is z >= 0, z pointing into it, the half-plane in plane strain. A pressure acts along +z, a shear traction along
+x. Stresses (..., 6) are in the order xx, yy, zz, xy, yz, xz, tension positive; coordinates broadcast.

The potential of a traction √(a² − r²) is that of sources on a complex line, (π/2) ∫ (a² + (ζ − z)²) / √(r² + ζ²) dζ/i
from ζ = z − ia to z + ia (its value on the surface, π² (2a² − r²) / 4, is Hertz's). All potentials of Boussinesq and
Cerruti (Johnson, Contact Mechanics, 1985, section 3.2) follow by integrating and differentiating under the integral. It
is taken along a half circle in the right half plane, where nothing is singular, by the double exponential rule, which
handles the root at the contact's edge (Takahasi & Mori, Publ. RIMS 9 (1974) 721).

Line contacts in partial slip follow Cattaneo and Mindlin (Johnson 1985, 7.2, 7.4) under constant normal load P and
tangential force Q per unit length; a is the half-width, c that of the stick zone. Displacements are left out: those of
a loaded half-plane depend on the point of reference.
"""

import math
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from geometry import Elastic
from geometry.arrays import Array, ComplexArray
from wirewear.reference.hertz import LineContact, require_positive

_STEPS = 96
_REACH = 3.2


def hertz_stress(
    x_mm: ArrayLike,
    y_mm: ArrayLike,
    z_mm: ArrayLike,
    *,
    contact_radius_mm: float,
    peak_pressure_MPa: float,
    poissons_ratio: float,
) -> Array:
    """Stresses (..., 6) in MPa in a half-space under Hertz's pressure p0 √(1 − r²/a²), a being the contact's radius.

    Raises ValueError for a radius that is not positive, or a point above the surface.
    """
    sizes = {"contact_radius_mm": contact_radius_mm, "peak_pressure_MPa": peak_pressure_MPa, "peak_shear_MPa": 0.0}
    return sliding_stress(x_mm, y_mm, z_mm, **sizes, poissons_ratio=poissons_ratio)


def sliding_stress(
    x_mm: ArrayLike,
    y_mm: ArrayLike,
    z_mm: ArrayLike,
    *,
    contact_radius_mm: float,
    peak_pressure_MPa: float,
    peak_shear_MPa: float,
    poissons_ratio: float,
) -> Array:
    """Stresses (..., 6) in MPa (xx, yy, zz, xy, yz, xz; tension positive) in a half-space z ≥ 0 under a pressure
    p0 √(1 − r²/a²) and a shear q0 √(1 − r²/a²) along +x: a sliding sphere for q0 = µ p0.

    The largest tension is on the surface at the trailing edge x = −a: p0 (1 − 2ν)/3 + q0 π (4 + ν)/8 (Hamilton, Proc.
    Inst. Mech. Eng. 197C (1983) 53). Raises ValueError for a radius that is not positive, or a point above the surface.
    """
    require_positive(contact_radius_mm=contact_radius_mm)
    x, y, z = np.broadcast_arrays(*(np.asarray(values, float) for values in (x_mm, y_mm, z_mm)))
    if np.any(z < 0.0):
        raise ValueError("the half-space is z_mm >= 0: a point lies above its surface")
    weights, path = _path()
    a, nu = contact_radius_mm, poissons_ratio
    point = [values[..., None] for values in (x, y, z)]
    zeta = point[2] + a * path
    # Of the traction sqrt(1 − r²/a²): the weight of √(a² − r²) over a.
    strength = weights * a * (1.0 + path**2) * a
    radial = _Radial(point[0], point[1], zeta)
    gradient = peak_pressure_MPa * _summed(_normal(radial, point[2], nu), strength)
    if peak_shear_MPa != 0.0:
        gradient = gradient + peak_shear_MPa * _summed(_tangential(radial, point[2], nu), strength)
    return _stress(gradient / (2.0 * np.pi), nu)


def partial_slip_stress(
    x_mm: ArrayLike,
    y_mm: ArrayLike,
    z_mm: ArrayLike,
    *,
    contact_radius_mm: float,
    stick_radius_mm: float,
    peak_pressure_MPa: float,
    friction: float,
    poissons_ratio: float,
) -> Array:
    """Stresses (..., 6) in MPa in a half-space in partial slip on first loading: as in sliding, less those of a shear
    on the stick zone.

    The shear is µ p0 [√(1 − r²/a²) − (c/a) √(1 − r²/c²)] along +x (Cattaneo 1938, Mindlin 1949). Raises ValueError for
    radii that are not positive, a stick zone larger than the contact, or a point above the surface.
    """
    require_positive(contact_radius_mm=contact_radius_mm, stick_radius_mm=stick_radius_mm)
    if stick_radius_mm > contact_radius_mm:
        raise ValueError(f"the stick radius {stick_radius_mm:g} mm exceeds the contact's, {contact_radius_mm:g} mm")

    def sliding(radius_mm: float, pressure_MPa: float, shear_MPa: float) -> Array:
        sizes = {"contact_radius_mm": radius_mm, "peak_pressure_MPa": pressure_MPa, "peak_shear_MPa": shear_MPa}
        return sliding_stress(x_mm, y_mm, z_mm, **sizes, poissons_ratio=poissons_ratio)

    shear = friction * peak_pressure_MPa
    centre = sliding(stick_radius_mm, 0.0, shear * stick_radius_mm / contact_radius_mm)
    return sliding(contact_radius_mm, peak_pressure_MPa, shear) - centre


@cache
def _path() -> tuple[ComplexArray, ComplexArray]:
    """Weights (including dζ / i a) and places (ζ − z) / a on the half circle from −i to i, for the quadrature."""
    t = np.linspace(-_REACH, _REACH, 2 * _STEPS + 1)
    angle = 0.5 * np.pi * np.tanh(0.5 * np.pi * np.sinh(t))
    speed = 0.25 * np.pi**2 * np.cosh(t) / np.cosh(0.5 * np.pi * np.sinh(t)) ** 2
    place = np.exp(1j * angle)
    # dζ / i = a e^(iθ) dθ, and the factor π/2 of the potential.
    return 0.5 * np.pi * speed * (t[1] - t[0]) * place, place


class _Radial:
    """Derivatives by s = r² of Ω = ζ ln(R + ζ) − R, L = ln(R + ζ) and V = 1/R, with R = √(s + ζ²); Ω_ζ = L, L_ζ = V."""

    def __init__(self, x: Array, y: Array, zeta: ComplexArray) -> None:
        self.x, self.y, self.zeta = x, y, zeta
        R = np.sqrt(x**2 + y**2 + zeta**2)
        D = R + zeta
        self.Omega2 = 0.25 / (R * D**2)
        self.Omega3 = -0.125 * (1.0 / (R**3 * D**2) + 2.0 / (R**2 * D**3))
        self.L1 = 0.5 / (R * D)
        self.L2 = -0.25 * (1.0 / (R**3 * D) + 1.0 / (R**2 * D**2))
        self.L3 = 0.25 * (1.5 / (R**5 * D) + 1.5 / (R**4 * D**2) + 1.0 / (R**3 * D**3))
        self.V1, self.V2 = -0.5 / R**3, 0.75 / R**5
        self.Vz, self.Vz1 = -zeta / R**3, 1.5 * zeta / R**5
        self.Vzz = -1.0 / R**3 + 3.0 * zeta**2 / R**5


def _normal(f: _Radial, z: Array, nu: float) -> list[list[ComplexArray]]:
    """2G ∂u_i/∂x_j, as nested lists over i and j, of a source of pressure.

    2π 2G u = −(1 − 2ν) ∇H − z ∇V + (…) e_z, with H_z = L and V = 1/R.
    """
    x, y, k = f.x, f.y, 1.0 - 2.0 * nu

    def plane(first: float | Array, second: float | Array, same: float) -> ComplexArray:
        by_log = 2.0 * same * f.L1 + 4.0 * first * second * f.L2
        by_source = 2.0 * same * f.V1 + 4.0 * first * second * f.V2
        return np.asarray(-(k * by_log + z * by_source))

    def down(along: Array) -> ComplexArray:
        """Derivative ∂u/∂z of a component in the plane; uses ∂H_x/∂z = V_x."""
        return np.asarray(-2.0 * along * (k * f.V1 + f.V1 + z * f.Vz1))

    def across(along: Array) -> ComplexArray:
        """Derivative of u_z in a direction of the plane."""
        return np.asarray(2.0 * along * (2.0 * (1.0 - nu) * f.V1 - z * f.Vz1))

    deep = 2.0 * (1.0 - nu) * f.Vz - f.Vz - z * f.Vzz
    return [
        [plane(x, x, 1.0), plane(x, y, 0.0), down(x)],
        [plane(y, x, 0.0), plane(y, y, 1.0), down(y)],
        [across(x), across(y), deep],
    ]


def _tangential(f: _Radial, z: Array, nu: float) -> list[list[ComplexArray]]:
    """2G ∂u_i/∂x_j times 2π, as nested lists over i and j, of a source of shear along x.

    u_x is 2V + 2ν Ω_xx − z L_xx, u_y is 2ν Ω_xy − z L_xy, u_z is (1 − 2ν) L_x − z V_x.
    """
    x, y = f.x, f.y

    def third(second: ComplexArray, cube: ComplexArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Derivatives by xxx, xxy and xyy of a radial function, from its second and third derivatives by s = r²."""
        return (
            12.0 * x * second + 8.0 * x**3 * cube,
            4.0 * y * second + 8.0 * x**2 * y * cube,
            4.0 * x * second + 8.0 * x * y**2 * cube,
        )

    of_omega, of_l = third(f.Omega2, f.Omega3), third(f.L2, f.L3)
    xxx, xxy, xyy = (2.0 * nu * omega - z * log for omega, log in zip(of_omega, of_l, strict=True))
    l_xx, l_xy = 2.0 * f.L1 + 4.0 * x**2 * f.L2, 4.0 * x * y * f.L2
    v_xx, v_xy = 2.0 * f.V1 + 4.0 * x**2 * f.V2, 4.0 * x * y * f.V2
    k = 1.0 - 2.0 * nu
    return [
        [4.0 * x * f.V1 + xxx, 4.0 * y * f.V1 + xxy, 2.0 * f.Vz + 2.0 * nu * l_xx - l_xx - z * v_xx],
        [xxy, xyy, 2.0 * nu * l_xy - l_xy - z * v_xy],
        [k * l_xx - z * v_xx, k * l_xy - z * v_xy, 2.0 * k * x * f.V1 - 2.0 * x * f.V1 - z * 2.0 * x * f.Vz1],
    ]


def _summed(terms: list[list[ComplexArray]], strength: ComplexArray) -> Array:
    """Sum of sources along the path, (..., 3, 3), from terms by row and column and the sources' strength."""
    rows = [[np.real((term * strength).sum(axis=-1)) for term in row] for row in terms]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def _stress(gradient: Array, nu: float) -> Array:
    """Stresses (..., 6) by Hooke's law from 2G times the displacement gradient (..., 3, 3)."""
    trace = nu / (1.0 - 2.0 * nu) * np.trace(gradient, axis1=-2, axis2=-1)
    strain = 0.5 * (gradient + np.swapaxes(gradient, -1, -2))
    normal = [strain[..., i, i] + trace for i in range(3)]
    return np.stack([*normal, strain[..., 0, 1], strain[..., 1, 2], strain[..., 0, 2]], axis=-1)


def line_stick_ratio(force_N_per_mm: float, limit_N_per_mm: float) -> float:
    """Stick ratio c/a = √(1 − |Q|/µP), 0 to 1, of a line contact on first loading; limit_N_per_mm is µP. Raises
    ValueError beyond it.
    """
    unused = 1.0 - abs(force_N_per_mm) / limit_N_per_mm
    if unused < -1e-9:
        raise ValueError(f"the tangential force must not exceed µP = {limit_N_per_mm:g} N/mm")
    return math.sqrt(max(unused, 0.0))


def line_stick_ratio_after_reversal(
    force_N_per_mm: float, reversal_force_N_per_mm: float, limit_N_per_mm: float
) -> float:
    """Ratio c'/a = √(1 − |Q* − Q|/(2µP)) of the inner edge of the zones that slip back after a reversal at Q* to the
    half-width; limit_N_per_mm is µP. Raises ValueError where |Q* − Q| exceeds 2µP.
    """
    return line_stick_ratio(0.5 * (reversal_force_N_per_mm - force_N_per_mm), limit_N_per_mm)


def line_loading_traction(contact: LineContact, friction: float, x_mm: ArrayLike, force_N_per_mm: float) -> Array:
    """Traction q(x) = µp0[√(1 − x²/a²) − (c/a)√(1 − x²/c²)] in MPa at distances x (any shape) on first loading of a
    line contact, odd in Q; each root counts as 0 where it is not real.
    """
    a = contact.half_width_mm
    c = a * line_stick_ratio(force_N_per_mm, friction * contact.normal_load_N_per_mm)
    x = np.asarray(x_mm, float)
    shape: Array = (np.sqrt(np.maximum(a**2 - x**2, 0.0)) - np.sqrt(np.maximum(c**2 - x**2, 0.0))) / a
    return math.copysign(friction, force_N_per_mm) * contact.peak_pressure_MPa * shape


def line_traction_after_reversal(
    contact: LineContact, friction: float, x_mm: ArrayLike, force_N_per_mm: float, reversal_force_N_per_mm: float
) -> Array:
    """Traction q(x) = q₁(Q*) − 2q₁((Q* − Q)/2) in MPa at distances x (any shape) after first loading to Q* and
    unloading to Q; q₁ is `line_loading_traction`.
    """
    change = 0.5 * (reversal_force_N_per_mm - force_N_per_mm)
    first = line_loading_traction(contact, friction, x_mm, reversal_force_N_per_mm)
    return first - 2.0 * line_loading_traction(contact, friction, x_mm, change)


def line_stick_shift(contact: LineContact, friction: float, bulk_stress_MPa: float) -> float:
    """Shift e = a σ/(4 µ p0) in mm of the stick zone's centre by a bulk tension σ in one of two equal bodies, in phase
    with Q.

    Friction µp0 √(1 − x²/a²) strains the surfaces relative to each other by 4 (1 − ν²) µp0 x/(aE). Subtracting µp0
    (c/a) √(1 − (x − e)²/c²) in a stick zone of half-width c about e leaves 4 (1 − ν²) µp0 e/(aE) there, which equals
    the bulk strain (1 − ν²) σ/E (Nowell & Hills, Int. J. Mech. Sci. 29 (1987) 355). It holds while e + c <= a, which is
    not checked.
    """
    return float(contact.half_width_mm * bulk_stress_MPa / (4.0 * friction * contact.peak_pressure_MPa))


def line_energy_per_cycle(
    contact: LineContact,
    friction: float,
    contact_modulus_MPa: float,
    force_N_per_mm: float,
    bulk_stress_MPa: float = 0.0,
) -> float:
    """Friction work in mJ per mm of a cycle of ±Q, four times the integral of µp s: at a distance t from the stick
    zone's centre the slip amplitude s is (µp0/(aE*)) [t √(t² − c²) − c² arccosh(t/c)] (Nowell & Hills 1987).

    bulk_stress_MPa: amplitude of a bulk tension in one of two equal bodies, in phase with Q, see `line_stick_shift`.
    Raises ValueError for a force of 0 or beyond µP, or a stick zone that reaches beyond the contact: slip is reversed
    there.
    """
    from scipy.integrate import quad

    a, shear = contact.half_width_mm, friction * contact.peak_pressure_MPa
    c = a * line_stick_ratio(force_N_per_mm, friction * contact.normal_load_N_per_mm)
    e = line_stick_shift(contact, friction, bulk_stress_MPa)
    if not 0.0 < c < a - abs(e):
        raise ValueError("the closed form holds for a stick zone within the contact")

    def work(x: float) -> float:
        t = max(abs(x - e), c)
        slip = shear / (a * contact_modulus_MPa) * (t * math.sqrt(t**2 - c**2) - c**2 * math.acosh(t / c))
        return 4.0 * slip * shear * math.sqrt(max(1.0 - (x / a) ** 2, 0.0))

    return float(quad(work, -a, e - c)[0] + quad(work, e + c, a)[0])


def half_plane_line_stiffness(
    first: Elastic, second: Elastic, half_width_mm: float, contact_length_mm: float, depth_mm: float = 5.0
) -> float:
    """Initial tangential stiffness in N/mm of a line contact of `contact_length_mm`, between two points on its axis at
    `depth_mm` in each body.

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
    """Stresses (..., 6) in MPa in a half-plane under p0 √(1 − x²/a²) and a shear q0 √(1 − x²/a²) along +x.

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
    """Stresses (..., 6) in MPa in a half-plane in partial slip of a line contact on first loading; stick_centre_mm:
    where a bulk stress shifts the centre of the stick zone to, see `line_stick_shift`.

    They are those of sliding, less those of a shear on the stick zone; the bulk stress itself is not included. On the
    surface, friction adds −2 µ p0 √(x² − c²)/a where it slips and nothing where it sticks (Hills & Nowell, Mechanics of
    Fretting Fatigue, 1994, section 4.2). Raises ValueError for widths that are not positive or a stick zone wider than
    the contact.
    """
    require_positive(half_width_mm=half_width_mm, stick_half_width_mm=stick_half_width_mm)
    if stick_half_width_mm > half_width_mm:
        raise ValueError(f"the stick half-width {stick_half_width_mm:g} mm exceeds the contact's, {half_width_mm:g} mm")

    def sliding(middle_mm: float, half_mm: float, pressure_MPa: float, shear_MPa: float) -> Array:
        sizes = {"half_width_mm": half_mm, "peak_pressure_MPa": pressure_MPa, "peak_shear_MPa": shear_MPa}
        return line_stress(np.asarray(x_mm, float) - middle_mm, z_mm, **sizes, poissons_ratio=poissons_ratio)

    shear = friction * peak_pressure_MPa
    middle = sliding(stick_centre_mm, stick_half_width_mm, 0.0, shear * stick_half_width_mm / half_width_mm)
    return sliding(0.0, half_width_mm, peak_pressure_MPa, shear) - middle
