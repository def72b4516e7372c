"""Stresses inside the bodies of a finished run: fields, files, pictures, yield and fatigue.

A stress is a row of six components, xx, yy, zz, xy, yz, xz. A position is a recorded moment of a cycle.
"""

from typing import TYPE_CHECKING

from geometry.lazy import loaded_late

if TYPE_CHECKING:
    from solvers.elasticity.linear_elasticity import von_mises
    from wirewear.stress.bodies import BodyState, WornBody, body_grid, body_states, integration_point_cloud, worn_body

__all__ = ["BodyState", "WornBody", "body_grid", "body_states", "integration_point_cloud", "von_mises", "worn_body"]

__getattr__ = loaded_late(__name__)
