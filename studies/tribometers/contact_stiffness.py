"""Theoretical stiffness of a cylinder on a flat: plane-strain finite elements of bodies assumed once for all rigs."""

from dataclasses import dataclass
from functools import lru_cache

from wirewear.reference import Elastic
from wirewear.simulation.workbench import Cylinder, Flat, GradedAxis, PlanarGeometry, build_planar, move_stuck

# Vertical columns of elements cannot follow a round bar's outline to where it stands upright.
_ARC = 0.9
_ELEMENTS_PER_HALF_WIDTH = 24
_PATCH = 3.0
_FAR_mm = 1.0
_GROWTH = 1.25


@dataclass(frozen=True)
class Bodies:
    """Shapes of pad and specimen, and where their motion is read, all in mm.

    The pad is half a round bar, gripped across its diameter; beyond the largest size it is a block with a
    cylindrical face, gripped at its back. The specimen is a block gripped at its lower face. Both grips are rigid.
    The motion is read on the contact's axis, at one depth below the surface of either body, or at the grip of a body
    that ends before.
    """

    pad_half_width_mm: float = 10.0
    pad_height_mm: float = 10.0
    specimen_half_width_mm: float = 20.0
    specimen_height_mm: float = 10.0
    point_depth_mm: float = 5.0

    def pad_size(self, radius_mm: float) -> tuple[float, float]:
        """Half-width and height of the pad of that radius."""
        return min(_ARC * radius_mm, self.pad_half_width_mm), min(radius_mm, self.pad_height_mm)

    def widest_contact(self, radius_mm: float) -> float:
        """Largest half-width of a contact that is small against both bodies, as contact theory has it."""
        return 0.25 * min(self.pad_size(radius_mm)[0], self.specimen_half_width_mm)


ASSUMED = Bodies()  #: What is assumed of published tribometers, whose authors give the radius only.


@lru_cache(maxsize=1024)
def line_contact_stiffness(
    radius_mm: float, half_width_mm: float, pad: Elastic, specimen: Elastic, bodies: Bodies = ASSUMED
) -> float:
    """Tangential stiffness in N/mm per mm of length just after reversal, between the points of reference.

    pad, specimen: elastic constants of cylinder and flat.

    The procedure of Infante-García et al., Sensors 20 (2020) 4152, section 2: plane strain, the contact loaded to the
    half-width, all of it sticking. Raises ValueError when the contact is not small against the bodies.
    """
    if not 0.0 < half_width_mm <= bodies.widest_contact(radius_mm):
        raise ValueError(f"half_width_mm must lie in 0 ... {bodies.widest_contact(radius_mm):g}, not {half_width_mm:g}")
    element = half_width_mm / _ELEMENTS_PER_HALF_WIDTH
    along = GradedAxis(element, 1.2 * half_width_mm, half_width_mm, _PATCH * half_width_mm)
    profile = Cylinder(radius_mm, curved_along=True)
    upper = build_planar(PlanarGeometry(profile, *bodies.pad_size(radius_mm), along, _FAR_mm, _GROWTH))
    size = bodies.specimen_half_width_mm, bodies.specimen_height_mm
    lower = build_planar(PlanarGeometry(Flat(), *size, along, _FAR_mm, _GROWTH))
    return move_stuck(upper, lower, pad, specimen, half_width_mm).stiffness_between(bodies.point_depth_mm)
