"""Stresses in an elastic half-space under round contacts: Hertz, sliding (Hamilton 1983), partial slip (N, mm, MPa).

The half-space is z >= 0, z into the body. A pressure acts along +z, a shear traction along +x. Stresses (..., 6) are in
the order xx, yy, zz, xy, yz, xz, tension positive.

The potential of a traction √(a² − r²) is that of sources on a complex line, (π/2) ∫ (a² + (ζ − z)²) / √(r² + ζ²) dζ/i
from ζ = z − ia to z + ia (its value on the surface, π² (2a² − r²) / 4, is Hertz's). All potentials of Boussinesq and
Cerruti (Johnson, Contact Mechanics, 1985, section 3.2) follow by integrating and differentiating under the integral. It
is taken along a half circle in the right half plane, where nothing is singular, by the double exponential rule, which
endures the root at the contact's edge (Takahasi & Mori, Publ. RIMS 9 (1974) 721).
"""

from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Array, ComplexArray
from wirewear.reference.hertz import require_positive

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
    """Stresses (..., 6) under the pressure p0 √(1 − r²/a²).

    Raises ValueError for a radius that is not positive, or a point above the surface.
    """
    return sliding_stress(
        x_mm,
        y_mm,
        z_mm,
        contact_radius_mm=contact_radius_mm,
        peak_pressure_MPa=peak_pressure_MPa,
        peak_shear_MPa=0.0,
        poissons_ratio=poissons_ratio,
    )


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
    """Stresses (..., 6) under p0 √(1 − r²/a²) and a shear q0 √(1 − r²/a²) along +x: a sliding sphere for q0 = µ p0.

    Its largest tension is on the surface at the trailing edge x = −a: p0 (1 − 2ν)/3 + q0 π (4 + ν)/8 (Hamilton, Proc.
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
    """Stresses (..., 6) at first loading in partial slip: sliding on the whole less that on the sticking centre.

    The shear is µ p0 [√(1 − r²/a²) − (c/a) √(1 − r²/c²)] along +x (Cattaneo 1938, Mindlin 1949). Raises ValueError for
    radii that are not positive or a centre larger than the contact.
    """
    require_positive(contact_radius_mm=contact_radius_mm, stick_radius_mm=stick_radius_mm)
    if stick_radius_mm > contact_radius_mm:
        raise ValueError(f"the stick radius {stick_radius_mm:g} mm exceeds the contact's, {contact_radius_mm:g} mm")
    shear = friction * peak_pressure_MPa
    whole = sliding_stress(
        x_mm,
        y_mm,
        z_mm,
        contact_radius_mm=contact_radius_mm,
        peak_pressure_MPa=peak_pressure_MPa,
        peak_shear_MPa=shear,
        poissons_ratio=poissons_ratio,
    )
    centre = sliding_stress(
        x_mm,
        y_mm,
        z_mm,
        contact_radius_mm=stick_radius_mm,
        peak_pressure_MPa=0.0,
        peak_shear_MPa=shear * stick_radius_mm / contact_radius_mm,
        poissons_ratio=poissons_ratio,
    )
    return whole - centre


@cache
def _path() -> tuple[ComplexArray, ComplexArray]:
    """Weights (including dζ / i a) and places (ζ − z) / a on the half circle from −i to i."""
    t = np.linspace(-_REACH, _REACH, 2 * _STEPS + 1)
    angle = 0.5 * np.pi * np.tanh(0.5 * np.pi * np.sinh(t))
    speed = 0.25 * np.pi**2 * np.cosh(t) / np.cosh(0.5 * np.pi * np.sinh(t)) ** 2
    place = np.exp(1j * angle)
    # dζ / i = a e^(iθ) dθ, and the factor π/2 of the potential.
    return 0.5 * np.pi * speed * (t[1] - t[0]) * place, place


class _Radial:
    """Derivatives by s = r² of Ω = ζ ln(R + ζ) − R, L = ln(R + ζ) and V = 1/R, R = √(s + ζ²): Ω_ζ = L, L_ζ = V."""

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
    """2G ∂u_i/∂x_j of a pressure's source: 2G u = −(1 − 2ν) ∇H − z ∇V + (…) e_z over 2π, H of L."""
    x, y, k = f.x, f.y, 1.0 - 2.0 * nu

    def plane(first: float | Array, second: float | Array, same: float) -> ComplexArray:
        by_log = 2.0 * same * f.L1 + 4.0 * first * second * f.L2
        by_source = 2.0 * same * f.V1 + 4.0 * first * second * f.V2
        return np.asarray(-(k * by_log + z * by_source))

    def down(along: Array) -> ComplexArray:
        """∂u/∂z of a component in the plane; ∂H_x/∂z = V_x."""
        return np.asarray(-2.0 * along * (k * f.V1 + f.V1 + z * f.Vz1))

    def across(along: Array) -> ComplexArray:
        """∂u_z by a direction in the plane."""
        return np.asarray(2.0 * along * (2.0 * (1.0 - nu) * f.V1 - z * f.Vz1))

    deep = 2.0 * (1.0 - nu) * f.Vz - f.Vz - z * f.Vzz
    return [
        [plane(x, x, 1.0), plane(x, y, 0.0), down(x)],
        [plane(y, x, 0.0), plane(y, y, 1.0), down(y)],
        [across(x), across(y), deep],
    ]


def _tangential(f: _Radial, z: Array, nu: float) -> list[list[ComplexArray]]:
    """2G ∂u_i/∂x_j of a shear's source, over 2π.

    u_x is 2V + 2ν Ω_xx − z L_xx, u_y is 2ν Ω_xy − z L_xy, u_z is (1 − 2ν) L_x − z V_x.
    """
    x, y = f.x, f.y

    def third(second: ComplexArray, cube: ComplexArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Of a radial function, its derivatives by xxx, xxy and xyy."""
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
    """Sources summed along the path: (..., 3, 3)."""
    rows = [[np.real((term * strength).sum(axis=-1)) for term in row] for row in terms]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def _stress(gradient: Array, nu: float) -> Array:
    """Hooke's law from 2G times the displacement gradient (..., 3, 3)."""
    trace = nu / (1.0 - 2.0 * nu) * np.trace(gradient, axis1=-2, axis2=-1)
    strain = 0.5 * (gradient + np.swapaxes(gradient, -1, -2))
    normal = [strain[..., i, i] + trace for i in range(3)]
    return np.stack([*normal, strain[..., 0, 1], strain[..., 1, 2], strain[..., 0, 2]], axis=-1)
