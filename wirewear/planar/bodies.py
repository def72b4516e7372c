"""Planar bodies: meshed, condensed and placed above or below the contact; the same for every planar study."""

from __future__ import annotations

from geometry import Elastic, PlanarGeometry, build_planar
from solvers import PlacedBody, condense, place
from wirewear.errors import StudyError


def placed_body(geometry: PlanarGeometry, material: Elastic, *, upper: bool) -> PlacedBody:
    """A body of that geometry and material in the contact."""
    meshed = build_planar(geometry)
    return place(condense(meshed.mesh, meshed.patch, material, bedding=meshed.bedding), upper=upper, axis_angle_rad=0.0)


def require_room(body: str, key: str, needed_mm: float, half_width_mm: float, remedy: str) -> None:
    """See that a body is wide enough for a contact that needs so much to each side of its middle.

    Raises:
        StudyError: it is not; the message names the key and ends with the remedy.
    """
    if needed_mm >= half_width_mm:
        raise StudyError(
            f"the {body} is too narrow for this test: the contact is expected to need {needed_mm:.3g} mm to each side "
            f"of its middle, but {key} is {half_width_mm:.3g}; {remedy}"
        )
