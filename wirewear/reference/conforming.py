"""Contacts of bodies that conform: a pin in a slightly wider bore, a taper that is pushed into a hub.

The pin's contact reaches far around: plane strain, no friction, alike materials.

Persson 1964, as printed by Ciavarella and Decuzzi, Int. J. Solids Struct. 38 (2001) 4507. The pin is loaded at its
centre, the plate reaches far. A half-angle is that of the contact, seen from the pin's centre.
"""

from dataclasses import dataclass
from math import atan, log, pi, tan

import numpy as np
from numpy.typing import ArrayLike

from geometry import Elastic
from geometry.arrays import Array
from wirewear.reference.hertz import require_positive
from wirewear.reference.wear import LineScar

__all__ = ["PinContact", "Taper", "pin_in_bore", "pin_scar"]

_WIDEST_rad = 2.0 * atan(0.914)  # Just beyond the half-angle of a pin without clearance.


@dataclass(frozen=True)
class PinContact:
    """A pin pressed into a bore."""

    normal_load_N_per_mm: float
    pin_radius_mm: float
    half_angle_rad: float

    @property
    def clearance_share(self) -> float:
        """2 E* ΔR / P for the radial clearance ΔR and the load per length P; it falls from infinity at a narrow contact
        to 0 at the widest.
        """
        b = tan(0.5 * self.half_angle_rad)
        return (2.0 - log(b**2 + 1.0) - 2.0 * b**4) / (pi * (b**2 + 1.0) * b**2)

    def pressure(self, angle_rad: ArrayLike) -> Array:
        """Pressure in MPa at angles from the middle of the contact, 0 outside (shape of `angle_rad`)."""
        b, t = tan(0.5 * self.half_angle_rad), np.tan(0.5 * np.asarray(angle_rad, float))
        root, whole = np.sqrt(np.maximum(b**2 - t**2, 0.0)), np.sqrt(1.0 + b**2)
        spread = np.log((whole + root) / (whole - root)) / (2.0 * pi * b**2 * (1.0 + b**2))
        per_radius = self.normal_load_N_per_mm / self.pin_radius_mm
        return np.asarray(per_radius * (2.0 / pi * root / (whole * (1.0 + t**2)) + spread))


def pin_in_bore(
    normal_load_N_per_mm: float, pin_radius_mm: float, bore_radius_mm: float, modulus_MPa: float
) -> PinContact:
    """The contact of a pin in a bore; modulus_MPa is E*, half the plane strain modulus of alike bodies.

    Raises ValueError for an argument that is not positive, or a bore that is not wider than the pin.
    """
    require_positive(
        normal_load_N_per_mm=normal_load_N_per_mm,
        pin_radius_mm=pin_radius_mm,
        clearance_mm=bore_radius_mm - pin_radius_mm,
        modulus_MPa=modulus_MPa,
    )
    from scipy.optimize import brentq

    wanted = 2.0 * modulus_MPa * (bore_radius_mm - pin_radius_mm) / normal_load_N_per_mm

    def contact(half_angle_rad: float) -> PinContact:
        return PinContact(normal_load_N_per_mm, pin_radius_mm, half_angle_rad)

    # Never above the angle sought.
    narrow = (pi * (wanted + 1.0)) ** -0.5
    return contact(
        float(brentq(lambda angle: contact(angle).clearance_share - wanted, narrow, _WIDEST_rad, xtol=1e-12))
    )


def pin_scar(area_mm2: float, pin_radius_mm: float, bore_radius_mm: float) -> LineScar:
    """Scar of rigid bodies that wear together: the pin has sunk into the bore until the worn area is `area_mm2`.

    With clearance c, the area 2Rc (tan s − s) ends at the half-angle s, the half-width Rs around the pin, and the
    depth is c (1/cos s − 1). Raises ValueError for an argument that is not positive, or a bore that is not wider.
    """
    from scipy.optimize import brentq

    clearance = bore_radius_mm - pin_radius_mm
    require_positive(area_mm2=area_mm2, pin_radius_mm=pin_radius_mm, clearance_mm=clearance)
    wanted = area_mm2 / (2.0 * pin_radius_mm * clearance)
    # Never below the angle sought, since tan s - s is at least s³/3.
    widest = min((3.0 * wanted) ** (1.0 / 3.0), 0.5 * pi * (1.0 - 1e-9))
    angle = widest if tan(widest) - widest < wanted else float(brentq(lambda s: tan(s) - s - wanted, 0.0, widest))
    return LineScar(area_mm2, clearance * (1.0 / np.cos(angle) - 1.0), pin_radius_mm * angle)


@dataclass(frozen=True)
class Taper:
    """A solid conical pin in a hub of one material and length: slices of both are Lamé's discs, which also carry the
    force along the axis.

    radius_mm: in the middle; rise: of the radius per mm along the axis. The hub is held at its narrow end, the pin
    pushed at its wide one.
    """

    radius_mm: float
    hub_radius_mm: float
    length_mm: float
    rise: float
    elastic: Elastic

    def assembly_force_N(self, push_mm: float, interference_mm: float, friction: float) -> float:
        """Force in N at which the pin, sliding all over, has been pushed in by push_mm; interference_mm: of its radius
        over the hub's before.

        Discs of radius r under the pressure p widen by p r/E times ((R² + r²)/(R² - r²) + nu) and 1 - nu (Timoshenko,
        Strength of Materials II); a force along the axis widens them by Poisson's ratio, and it and the pressure
        change their length, and so how far the pin comes.
        """
        from scipy.integrate import cumulative_trapezoid

        modulus, nu, outer = self.elastic.youngs_modulus_MPa, self.elastic.poissons_ratio, self.hub_radius_mm
        x = np.linspace(-0.5, 0.5, 2001) * self.length_mm
        r = self.radius_mm + self.rise * x
        wall = outer**2 - r**2
        softness = ((outer**2 + r**2) / wall + 1.0) / modulus
        along = (self.rise + friction) / (1.0 - self.rise * friction)
        pressure = (interference_mm + self.rise * push_mm) / (r * softness)
        # The force is a correction of some per cent, which settles by a tenth each time.
        for _ in range(20):
            behind = cumulative_trapezoid(2.0 * pi * r * pressure * along, x, initial=0.0)
            pin, hub = behind / (pi * r**2), (behind[-1] - behind) / (pi * wall)
            longer = cumulative_trapezoid(2.0 * nu * pressure - pin, x, initial=0.0)
            shorter = cumulative_trapezoid(2.0 * nu * pressure * r**2 / wall + hub, x, initial=0.0)
            overlap = interference_mm + self.rise * (push_mm + (longer[-1] - longer - shorter) / modulus)
            pressure = (overlap / r + nu * (pin - hub) / modulus) / softness
        return float(behind[-1])
