"""What a cycle does to the material of a line contact: yield and fatigue indicators of pad and specimen."""

from __future__ import annotations

from wirewear.interior.strength import Strength, StrengthAsked, require_room, strength_over
from wirewear.planar.fields import state_grid
from wirewear.planar.inside import planar_states, run_geometry
from wirewear.results import RunResult


def planar_strength(result: RunResult, body: str, cycle: int, asked: StrengthAsked) -> Strength:
    """Stresses of the pad or specimen over a recorded cycle, at all its recorded positions, at nodes near the contact.

    Averages are over discs. Raises ResultError when no contact forces of it are recorded or it is smaller than the
    averaging length, GeometryError when wear distorts the mesh too much.
    """
    return strength_over(planar_states(result, body, planar_assessable(result, body, cycle, asked)), asked, state_grid)


def planar_assessable(result: RunResult, body: str, cycle: int, asked: StrengthAsked) -> int:
    """The cycle itself, seen without any computation to allow what is asked of a body.

    Raises:
        ResultError: no contact forces of it are recorded, or it is smaller than the averaging length.
    """
    forces, geometry = result.forces(cycle, body), run_geometry(result, body)
    require_room(body, min(2.0 * geometry.half_width_mm, geometry.height_mm), asked.averaging_length_um)
    return forces.cycle
