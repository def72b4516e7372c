"""Residual stress that the first loading of a contact at a point leaves in bodies that yield.

Both bodies are one half-space under a rigid profile (`solvers.stress.pressing`), perfectly plastic or with kinematic
hardening, pressed by the study's load without friction and unloaded. Wear takes the stressed metal away.
"""

import json
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.ndimage import map_coordinates

from geometry import ContactPatch, Elastic
from geometry.arrays import Array
from solvers.elasticity.placement import rotation_to_world
from solvers.errors import NotConvergedError
from solvers.laws.plasticity import Metal
from solvers.stress.half_space import HalfSpace
from solvers.stress.plastic_zone import PlasticZone
from solvers.stress.pressing import indented
from wirewear import reference
from wirewear.base.errors import ResultError
from wirewear.results import ContactForces, RunResult
from wirewear.simulation import limit_of_points, spread_by_yield
from wirewear.test import Study, study_from_tables
from wirewear.test.bodies import hertz_of

_FINE, _WIDE, _MOST = 6, 8.0, 129  #: Points to the contact's smaller semi-axis, semi-axes across, points along a side.
_LAYERS = np.asarray(0.1 * 1.1 ** np.arange(15), dtype=np.float64)  #: Over the smaller semi-axis.
_STEPS = 12  #: Of the load, which goes with their square.


@dataclass(frozen=True, eq=False)
class Residual:
    """Stresses (l, n, n, 6) in MPa in a body's axes, on a square grid of spacing step_mm about the first point of
    contact, at depths_mm (l,) below the unworn surface.
    """

    stress: Array
    step_mm: float
    depths_mm: Array

    def at(self, places_mm: Array, patch: ContactPatch) -> Array:
        """Stresses (k, 6) at places (k, 3) in mm of the body, zero beyond the grid. patch: gives the unworn height."""
        depth = patch.profile.height(places_mm[:, :2]) - places_mm[:, 2]
        count = np.arange(len(self.depths_mm), dtype=np.float64)
        index = [np.interp(depth, self.depths_mm, count, right=float(len(count)))]
        index += [at / self.step_mm + self.stress.shape[1] // 2 for at in places_mm[:, :2].T]
        return np.stack([map_coordinates(self.stress[..., k], index, order=1) for k in range(6)], axis=-1)


def residual_of(result: RunResult, forces: ContactForces) -> Residual | None:
    """Residual stress after first loading of the body that `forces` act on; None if it stays elastic, or the study does
    not ask for "near zone". Raises ResultError for a pad, or if no solution is found.
    """
    if result.study.get("contact", {}).get("plasticity") != "near zone":
        return None
    tables = json.dumps(result.study, sort_keys=True, default=str)
    return _pressed(tables, forces.axis_angle_deg, result.is_upper(forces.body))


@lru_cache(maxsize=4)
def _pressed(tables: str, axis_angle_deg: float, upper: bool) -> Residual | None:
    study: Study = study_from_tables(json.loads(tables), "the result")
    load, limit = study.conditions.normal_load_N, limit_of_points(study)
    if limit is None or limit.share(upper=upper) == 0.0 or load <= limit.first_yield_load:
        return None
    bodies = study.bodies
    softer = next(body for body in bodies if body.yield_stress_MPa == limit.yield_stress_MPa)
    hertz, nu = hertz_of(load, *bodies), softer.poissons_ratio
    modulus = reference.contact_modulus(*(body.material for body in bodies)) * (1.0 - nu**2)
    # Strains of a half-space that is both bodies are larger than those of one.
    metal = Metal(limit.yield_stress_MPa, limit.hardening_MPa * modulus / softer.youngs_modulus_MPa)
    wider = spread_by_yield(limit, load, hertz.peak_pressure_MPa)
    minor, major = wider * hertz.minor_semi_axis_mm, wider * hertz.major_semi_axis_mm
    half = min(int(0.5 * _WIDE * _FINE * major / minor), _MOST // 2)
    step = 0.5 * _WIDE * major / half
    space = HalfSpace(Elastic(modulus, nu), (2 * half + 1, 2 * half + 1), (step, step), minor * _LAYERS)
    turn = rotation_to_world(upper=upper, axis_angle_rad=float(np.radians(axis_angle_deg)))[:2, :2]
    places = np.stack(np.meshgrid(*space.axes_mm(), indexing="ij"), axis=-1) @ turn.T
    curvature = sum((body.curvature_per_mm() for body in bodies), np.zeros((2, 2)))
    gap = 0.5 * np.einsum("xyi,ij,xyj->xy", places, curvature, places)
    zone = PlasticZone(space, metal)
    try:
        *_, last = indented(zone, gap, load * (np.arange(1, _STEPS + 1) / _STEPS) ** 2)
        left = zone.under(np.zeros_like(last.state.traction_MPa), last.state)
    except NotConvergedError:
        raise ResultError("residual stress beneath the contact could not be found; please report this study") from None
    return Residual(left.stress, step, space.depths_mm)
