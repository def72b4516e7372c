"""What a cycle does to the material of a line contact: yield and fatigue indicators of pad and specimen."""

from __future__ import annotations

from wirewear.interior.strength import Asked, Strength, strength_over
from wirewear.planar.fields import state_grid
from wirewear.planar.inside import planar_states
from wirewear.planar.results import PlanarResult


def planar_strength(result: PlanarResult, body: str, cycle: int, asked: Asked) -> Strength:
    """Stresses of the pad or specimen over a recorded cycle, at all its recorded positions, at nodes near the contact.

    Averages are over discs. Raises ResultError when no contact forces of it are recorded or it is smaller than the
    averaging length, GeometryError when wear distorts the mesh too much.
    """
    return strength_over(planar_states(result, body, cycle), asked, state_grid)
