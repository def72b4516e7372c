"""Stuck line contact in plane strain: tangential stiffness between two points, against half-planes.

Just after a reversal a line contact sticks all over. Between points close to it, blocks far wider than their distance
are as stiff as half-planes under the traction Q/(π√(a² − x²)); this is what `studies.tribometers` computes for
bodies of real size.
"""

from __future__ import annotations

from geometry import Elastic, Flat, GradedAxis, PlanarGeometry, build_planar
from solvers import move_stuck
from wirewear import reference
from wirewear.verification.level import Level
from wirewear.verification.rows import Row, compared

MATERIAL = Elastic(200_000.0, 0.3)
HALF_WIDTH_mm = 0.1
DEPTH_mm = 1.0
_BLOCK_mm = 60.0
_FAR_mm = 3.0
_TOLERANCE = 0.02


def stuck_line_rows(level: Level) -> tuple[Row, ...]:
    """Stiffness per length between points 1 mm deep under a contact 0.2 mm wide."""
    a = HALF_WIDTH_mm
    along = GradedAxis(a / level.line_resolution, 1.2 * a, a, 3.0 * a)
    block = build_planar(PlanarGeometry(Flat(), _BLOCK_mm, _BLOCK_mm, along, _FAR_mm, 1.2))
    material = Elastic(MATERIAL.youngs_modulus_MPa, MATERIAL.poissons_ratio)
    computed = move_stuck(block, block, material, material, a).stiffness_between(DEPTH_mm)
    exact = reference.half_plane_line_stiffness(MATERIAL, MATERIAL, a, 1.0, DEPTH_mm)
    return (compared("Line contact, stuck", "stiffness, points 1 mm deep [N/mm²]", computed, exact, _TOLERANCE),)
