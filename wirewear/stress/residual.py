"""What yield changes inside bodies: the friction that they bear, and the residual stress of contacts at a point.

A run keeps the friction that its study states; inside, tractions beyond the yield stress in shear would be stresses
that metal cannot have. Plastic strain stays with the metal, and acts as initial strain of what wear has left of the
body: metal that is taken away no longer holds the rest, and the worn surface is free of stress.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import sqrt

import numpy as np
from scipy.ndimage import map_coordinates

from geometry import ContactPatch, Elastic
from geometry.arrays import Array
from solvers.elasticity.linear_elasticity import IntegrationPoints, turned
from solvers.elasticity.placement import rotation_to_world
from solvers.stress.interior import Interior
from wirewear.results import ContactForces, RunResult
from wirewear.results.values import YIELD_STRESS, PlasticStrain


def with_friction_borne(result: RunResult, forces: ContactForces, patch: ContactPatch) -> ContactForces:
    """Contact forces on a body with surface `patch`, whose friction is at most the yield stress in shear, by von Mises,
    of the softer body of the run; unchanged where no body yields.
    """
    if (yields_MPa := result.settings.get(YIELD_STRESS)) is None:
        return forces
    slope = patch.gradient(patch.height(patch.grid()).reshape(patch.shape))[forces.nodes]
    across = np.column_stack([-slope, np.ones(len(slope))])
    stretched = np.linalg.norm(across, axis=1)
    normal = across / stretched[:, None]
    pressing = np.einsum("kmi,mi->km", forces.force_N, normal)[..., None] * normal
    friction = forces.force_N - pressing
    size = np.linalg.norm(friction, axis=-1)
    borne = float(yields_MPa) / sqrt(3.0) * stretched * patch.node_areas()[forces.nodes]
    share = np.minimum(borne / np.maximum(size, np.finfo(np.float64).tiny), 1.0)
    return replace(forces, force_N=pressing + share[..., None] * friction) if share.min() < 1.0 else forces


@dataclass(frozen=True, eq=False)
class Residual:
    """Residual stresses (m, q, 6) in MPa at the integration points `points` of a body's mesh, in the body's axes."""

    points: IntegrationPoints
    at_points: Array

    @cached_property
    def at_nodes(self) -> Array:
        return self.points.at_nodes(self.at_points)


def residual_stress(strain: Array, points: IntegrationPoints, interior: Interior, material: Elastic) -> Residual:
    """The stress by plastic strain (m, q, 6) at the integration points of a body, in its own axes."""
    initial = 2.0 * material.shear_modulus_MPa * strain
    force = points.internal_forces(initial)
    (moved,) = interior.displacements(np.arange(len(force)), force[None])
    return Residual(points, points.stresses(material, moved) - initial)


def residual_of(
    result: RunResult,
    forces: ContactForces,
    patch: ContactPatch,
    points: IntegrationPoints,
    interior: Interior,
    material: Elastic,
) -> Residual | None:
    """Residual stress in a run's body, meshed in its present surface; None if it has none."""
    strain = next((one for one in result.plastic_strain if one.body == forces.body), None)
    if strain is None:
        return None
    to_world = rotation_to_world(upper=result.is_upper(forces.body), axis_angle_rad=np.radians(forces.axis_angle_deg))
    places = points.positions.reshape(-1, 3)
    depth = patch.profile.height(places[:, :2]) - places[:, 2]
    turn = np.eye(3)
    turn[:2, :2] = to_world[:2, :2]
    # Out of the surface is z of the strain and of the body.
    own = turned(_strain_at(strain, places[:, :2] @ turn[:2, :2].T, depth), turn.T).reshape(*points.volumes.shape, 6)
    # Strain that varies within an element stresses it in ways that its corners cannot follow.
    mean = np.einsum("mq,mqk->mk", points.volumes, own) / points.volumes.sum(axis=1)[:, None]
    return residual_stress(np.broadcast_to(mean[:, None], own.shape), points, interior, material)


def _strain_at(strain: PlasticStrain, places_mm: Array, depth_mm: Array) -> Array:
    """Strains (k, 6) at places (k, 2) and depths (k,) in the axes of the test; zero away from the contact."""

    def index(at: Array, lines: Array, left: float) -> Array:
        return np.interp(at, lines, np.arange(len(lines)), left, len(lines))

    layer = index(depth_mm, strain.depths_mm, 0.0)
    plane = [index(at, own, -1.0) for at, own in zip(places_mm.T, (strain.along_mm, strain.across_mm), strict=True)]
    return np.stack([map_coordinates(strain.strain[..., k], [layer, *plane], order=1) for k in range(6)], axis=-1)
