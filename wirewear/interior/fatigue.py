"""Fatigue indicators of stress histories over a cycle: Smith–Watson–Topper and Crossland, averaged over a length.

Histories are (s, n, 6): s positions of a closed cycle, n material points. Linear elasticity: strains follow by Hooke's
law, so an indicator says where cracks begin first, and compares tests; a life needs data of the material.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix, diags
from scipy.spatial import cKDTree

from geometry import Elastic
from geometry.arrays import Array, IntArray
from solvers.strain import tensors

_DIRECTIONS = 240
#: Angles by which planes are tilted about the best one so far, rad.
_TILTS = (0.08, 0.04, 0.02, 0.01)
_BALL_STEPS = 60
_AT_ONCE = 2000  #: Stress histories whose planes are searched at once.


@dataclass(frozen=True, eq=False)
class CriticalPlanes:
    """Smith–Watson–Topper's parameter (n,) in MPa, the largest over all planes, and the normals of these (n, 3)."""

    parameter_MPa: Array
    normal: Array


@dataclass(frozen=True, eq=False)
class Crossland:
    """Crossland's two stresses (n,) in MPa: amplitude of the root of J2, and largest hydrostatic stress."""

    amplitude_MPa: Array
    hydrostatic_MPa: Array

    def equivalent_MPa(self, slope: float) -> Array:
        """√J2,a + slope · σ_H,max, to be compared with the fatigue limit in torsion."""
        return self.amplitude_MPa + slope * self.hydrostatic_MPa


def smith_watson_topper(history: Array, material: Elastic) -> CriticalPlanes:
    """σ_n,max · Δε_n / 2 on the plane where it is largest (Smith, Watson & Topper, J. Materials 5 (1970) 767).

    On planes as by Socie, J. Eng. Mater. Technol. 109 (1987) 293; a plane that is never pulled has 0. The planes are
    searched in 240 directions spread evenly over a hemisphere, and refined about the best one to 0.6°.
    """
    parts = [_critical(history[:, k : k + _AT_ONCE], material) for k in range(0, max(history.shape[1], 1), _AT_ONCE)]
    return CriticalPlanes(np.concatenate([p for p, _ in parts]), np.concatenate([n for _, n in parts]))


def crossland(history: Array) -> Crossland:
    """√J2 of the cycle as the radius of the smallest ball about the path of the deviatoric stress over √2.

    Crossland, Proc. Int. Conf. Fatigue of Metals, 1956; the ball by Badoiu & Clarkson, Comput. Geom. 40 (2008) 14.
    """
    pressure = history[..., :3].mean(axis=-1)
    path = history.copy()
    path[..., :3] -= pressure[..., None]
    # Shears count twice in the norm of the tensor.
    path[..., 3:] *= np.sqrt(2.0)
    centre = 0.5 * (path.max(axis=0) + path.min(axis=0))
    radius = np.full(path.shape[1], np.inf)
    for k in range(_BALL_STEPS):
        distance = np.linalg.norm(path - centre, axis=-1)
        farthest = distance.argmax(axis=0)
        points = np.arange(path.shape[1])
        radius = np.minimum(radius, distance[farthest, points])
        centre = centre + (path[farthest, points] - centre) / (k + 2.0)
    return Crossland(radius / np.sqrt(2.0), pressure.max(axis=0))


def averaging(points_mm: Array, volumes_mm3: Array, chosen: IntArray, length_mm: float) -> csr_matrix:
    """The matrix (k, n) of means over balls of diameter `length_mm` about chosen points (k,), weighted by volume (n,).

    What gradients beneath a contact ask for: a material's crack needs stress over a length, not at a point (Taylor,
    Int. J. Fatigue 21 (1999) 413). A length of zero leaves values as they are.
    """
    size = len(points_mm)
    if length_mm <= 0.0:
        return csr_matrix((np.ones(len(chosen)), (np.arange(len(chosen)), chosen)), shape=(len(chosen), size))
    near = cKDTree(points_mm).query_ball_point(points_mm[chosen], 0.5 * length_mm)
    counts = np.array([len(each) for each in near])
    columns = np.concatenate([np.asarray(each, dtype=np.int64) for each in near])
    rows = np.repeat(np.arange(len(chosen)), counts)
    weights = csr_matrix((volumes_mm3[columns], (rows, columns)), shape=(len(chosen), size))
    return csr_matrix(diags(1.0 / np.asarray(weights.sum(axis=1)).ravel()) @ weights)


def _critical(history: Array, material: Elastic) -> tuple[Array, Array]:
    stress = tensors(history)
    spread = _hemisphere(_DIRECTIONS)
    values = _parameter(stress, np.broadcast_to(spread, (history.shape[1], *spread.shape)), material)
    best = values.argmax(axis=1)
    normal, parameter = spread[best], values.max(axis=1)
    for tilt in _TILTS:
        tried = _tilted(normal, tilt)
        values = _parameter(stress, tried, material)
        best, found = values.argmax(axis=1), values.max(axis=1)
        better = found > parameter
        normal = np.where(better[:, None], tried[np.arange(len(best)), best], normal)
        parameter = np.maximum(parameter, found)
    return parameter, normal


def _parameter(stress: Array, normals: Array, material: Elastic) -> Array:
    """σ_n,max Δε_n / 2 (n, k) of tensors (s, n, 3, 3) on planes (n, k, 3)."""
    across = np.einsum("snij,nkj->snki", stress, normals, optimize=True)
    normal = np.einsum("snki,nki->snk", across, normals, optimize=True)
    nu, modulus = material.poissons_ratio, material.youngs_modulus_MPa
    trace = np.trace(stress, axis1=-2, axis2=-1)[..., None]
    strain = ((1.0 + nu) * normal - nu * trace) / modulus
    return np.asarray(np.maximum(normal.max(axis=0), 0.0) * 0.5 * np.ptp(strain, axis=0))


def _hemisphere(count: int) -> Array:
    """Directions (count, 3) spread evenly over half a sphere, by the golden angle."""
    k = np.arange(count)
    z = (k + 0.5) / count
    angle = np.pi * (3.0 - np.sqrt(5.0)) * k
    r = np.sqrt(1.0 - z**2)
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), z])


def _tilted(normal: Array, angle_rad: float) -> Array:
    """Eight directions (n, 8, 3) at an angle from each of (n, 3)."""
    helper = np.where(np.abs(normal[:, [2]]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    first = np.cross(normal, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(normal, first)
    turn = np.arange(8) * np.pi / 4.0
    aside = np.cos(turn)[:, None] * first[:, None] + np.sin(turn)[:, None] * second[:, None]
    return np.asarray(np.cos(angle_rad) * normal[:, None] + np.sin(angle_rad) * aside)
