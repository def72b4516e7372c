"""A pin in a slightly wider bore, whose contact reaches far around: plane strain, no friction, alike materials.

Persson 1964, as printed by Ciavarella and Decuzzi, Int. J. Solids Struct. 38 (2001) 4507. The pin is loaded at its
centre, the plate reaches far. A half-angle is that of the contact, seen from the pin's centre.
"""

from dataclasses import dataclass
from math import atan, log, pi, tan

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from geometry.arrays import Array
from wirewear.reference.hertz import require_positive
from wirewear.reference.wear import LineScar

__all__ = ["PinContact", "pin_in_bore", "pin_scar"]

_WIDEST_rad = 2.0 * atan(0.914)  # Just beyond the half-angle of a pin without clearance.


@dataclass(frozen=True)
class PinContact:
    """A pin pressed into a bore."""

    normal_load_N_per_mm: float
    pin_radius_mm: float
    half_angle_rad: float

    @property
    def clearance_share(self) -> float:
        """Twice E* times the clearance over the load per length; falls from infinity to 0 at the widest contact."""
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
    clearance = bore_radius_mm - pin_radius_mm
    require_positive(area_mm2=area_mm2, pin_radius_mm=pin_radius_mm, clearance_mm=clearance)
    wanted = area_mm2 / (2.0 * pin_radius_mm * clearance)
    # Never below the angle sought, since tan s - s is at least s³/3.
    widest = min((3.0 * wanted) ** (1.0 / 3.0), 0.5 * pi * (1.0 - 1e-9))
    angle = widest if tan(widest) - widest < wanted else float(brentq(lambda s: tan(s) - s - wanted, 0.0, widest))
    return LineScar(area_mm2, clearance * (1.0 / np.cos(angle) - 1.0), pin_radius_mm * angle)
