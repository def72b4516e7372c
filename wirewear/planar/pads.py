"""What the face of a pad means for its contact: how wide it is, how wide its scar gets, where meshes must be fine."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np

from geometry import Cylinder, EdgeGradedAxis, EvenProfile, GradedAxis, RoundedFlat
from wirewear import reference
from wirewear.planar.tables import Face

#: Half-width of a pad whose study does not say.
_WIDEST_mm = 10.0
_ACROSS_RADIUS = 0.8
# Elements in the middle of a flat contact, where nothing changes quickly, over those at its edges.
_MIDDLE = 5.0
_LEAST_MIDDLE = 0.25


def half_width_of(face: Face) -> float:
    """Half-width of a pad that its study leaves open, mm."""
    match face:
        case Cylinder(radius_mm=radius):
            return min(_WIDEST_mm, _ACROSS_RADIUS * radius)
        case RoundedFlat(half_width_mm=flat, edge_radius_mm=radius):
            return flat + min(_WIDEST_mm, _ACROSS_RADIUS * radius)
        case EvenProfile(points_mm=points):
            return min(_WIDEST_mm, points[-1][0])


def fresh_contact(
    face: Face, load_N_per_mm: float, modulus_MPa: float, pad_half_width_mm: float
) -> reference.LineContact:
    """The contact before any wear, with half-planes behind it.

    Raises:
        ValueError: the pad is too narrow to bear the load.
    """
    if isinstance(face, Cylinder):
        return reference.hertz_line(load_N_per_mm, face.radius_mm, modulus_MPa)
    return reference.even_line_contact(face, load_N_per_mm, modulus_MPa, pad_half_width_mm)


def edge_reach(face: Face, load_N_per_mm: float, modulus_MPa: float, contact: reference.LineContact) -> float:
    """Width beside its edge over which a contact's pressure changes quickly, mm.

    For a flat, how far the contact would reach beyond the flat, and inside it, were all the load on one rounded edge.
    """
    if isinstance(face, RoundedFlat):
        return sqrt(4.0 * load_N_per_mm * face.edge_radius_mm / (pi * modulus_MPa))
    return contact.half_width_mm


def farthest_contact(face: Face, reach_mm: float, tilt_rad: float, contact: reference.LineContact) -> float:
    """How far to a side a pad touches that tilts by so much: around where its face is as steep, mm."""
    match face:
        case Cylinder(radius_mm=radius):
            return contact.half_width_mm + radius * tilt_rad
        case RoundedFlat(half_width_mm=flat, edge_radius_mm=radius):
            return flat + reach_mm + radius * tilt_rad
        case EvenProfile(points_mm=points):
            x = np.linspace(0.0, points[-1][0], 400)
            steep = -face.slope(np.column_stack([x, np.zeros_like(x)]))[:, 0] >= tilt_rad
            return contact.half_width_mm + float(x[steep][0] if steep.any() else x[-1])


def scar_half_width(face: Face, area_mm2: float, pad_half_width_mm: float) -> float:
    """Half-width of the scar of both bodies together in gross slip, mm.

    Raises:
        ValueError: the pad is too narrow to hold it.
    """
    if area_mm2 <= 0.0:
        return 0.0
    if isinstance(face, Cylinder):
        return reference.line_contact_scar(area_mm2, face.radius_mm).half_width_mm
    return reference.even_line_scar(face, area_mm2, pad_half_width_mm).half_width_mm


def edge_graded(fine_mm: float, fine_from_mm: float, half_mm: float) -> EdgeGradedAxis | GradedAxis:
    """Mesh lines that are fine towards the ends and coarser in the middle."""
    return EdgeGradedAxis(fine_mm, _MIDDLE * fine_mm, fine_from_mm, half_mm)


def middle_of(face: RoundedFlat, reach_mm: float, moved_mm: float = 0.0) -> float:
    """Half-width of the part of a flat contact that lies away from both edges, even when it has moved so far, mm."""
    return max(face.half_width_mm - reach_mm - moved_mm, _LEAST_MIDDLE * face.half_width_mm)
