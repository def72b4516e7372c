"""Stresses inside the bodies of a finished run: fields, files, pictures, yield and fatigue."""

from solvers.strain import von_mises
from wirewear.interior.bodies import BodyState, WornBody, body_states, worn_body
from wirewear.interior.grids import body_grid, integration_point_cloud

__all__ = ["BodyState", "WornBody", "body_grid", "body_states", "integration_point_cloud", "von_mises", "worn_body"]
