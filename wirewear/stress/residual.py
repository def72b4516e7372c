"""Residual stress that the first cycles of a contact at a point leave in bodies whose metal flows; wear takes the
stressed metal away.
"""

import json
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import map_coordinates

from geometry import ContactPatch
from geometry.arrays import Array
from solvers import SolverError
from solvers.elasticity.placement import rotation_to_world
from wirewear.base.errors import ResultError
from wirewear.results import ContactForces, RunResult
from wirewear.simulation import NEAR_ZONE, FlowGrid, near_zone_of_tables


@dataclass(frozen=True, eq=False)
class Residual:
    """Stresses (l, n_x, n_y, 6) in MPa beneath the first point of contact, in the axes of the test, z out of the body.

    turn: (2, 2) from the body's axes to those of the test.
    """

    stress: Array
    grid: FlowGrid
    turn: Array

    def at(self, places_mm: Array, patch: ContactPatch) -> Array:
        """Stresses (k, 6) at places (k, 3), both in the body's axes; zero away from the contact."""
        depth = patch.profile.height(places_mm[:, :2]) - places_mm[:, 2]
        count = np.arange(len(self.grid.depths_mm), dtype=np.float64)
        layer = np.interp(depth, self.grid.depths_mm, count, right=float(len(count)))
        index = [layer, *self.grid.index(places_mm[:, :2] @ self.turn.T)]
        xx, yy, zz, xy, yz, xz = (map_coordinates(self.stress[..., k], index, order=1) for k in range(6))
        plane = np.einsum("ai,bj,abk->ijk", self.turn, self.turn, np.array([[xx, xy], [xy, yy]]))
        along, across = np.einsum("ai,ak->ik", self.turn, np.array([xz, yz]))
        return np.stack([plane[0, 0], plane[1, 1], zz, plane[0, 1], across, along], axis=-1)


def residual_of(result: RunResult, forces: ContactForces) -> Residual | None:
    """Residual stress in a run's body after its first cycles; None if it stays elastic, or the study asks for none."""
    if result.study.get("contact", {}).get("plasticity") != NEAR_ZONE:
        return None
    try:
        zone = near_zone_of_tables(json.dumps(result.study, sort_keys=True, default=str))
    except SolverError as error:
        raise ResultError(str(error)) from None
    upper = result.is_upper(forces.body)
    if zone is None or not (left := zone.sliding.rubbed.unloaded[0 if upper else 1]).flow.accumulated.any():
        return None
    turn = rotation_to_world(upper=upper, axis_angle_rad=float(np.radians(forces.axis_angle_deg)))[:2, :2]
    return Residual(left.stress, zone.sliding, turn)
