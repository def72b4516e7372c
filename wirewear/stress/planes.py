"""Fatigue indicators of stress histories: on the worst plane of a point, and Crossland's.

Histories are (s, n, 6) in MPa: components xx, yy, zz, xy, yz, xz at s positions of a closed cycle and n material
points; stresses of shape (s, n, 3, 3) are the same as tensors. Planes are given by unit normals, (n, k, 3) for k planes
a point. Linear elasticity: strains follow by Hooke's law, so an indicator says where cracks begin first, and compares
tests; a life needs data of the material.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from geometry import Elastic
from geometry.arrays import Array
from solvers.elasticity.linear_elasticity import tensors
from solvers.jit_cache import compiled

_DIRECTIONS = 240

#: Angles by which planes are tilted about the best one so far, rad.
_TILTS = (0.08, 0.04, 0.02, 0.01)
_AT_ONCE = 64  #: Stress histories whose planes are searched at once: what is made of them stays in a processor's cache.

#: A parameter (n, k) of stress tensors (s, n, 3, 3) over a cycle on planes of k normals each, (n, k, 3).
OnPlanes = Callable[[Array, Array], Array]


@dataclass(frozen=True, eq=False)
class CriticalPlanes:
    """Largest value (n,) of a parameter over all planes at n points, and the plane's unit normal (n, 3)."""

    parameter: Array
    normal: Array


@dataclass(frozen=True, eq=False)
class Crossland:
    """Crossland's two stresses (n,) in MPa: amplitude of the root of J2, and largest hydrostatic stress."""

    amplitude_MPa: Array
    hydrostatic_MPa: Array

    def equivalent_MPa(self, slope: float) -> Array:
        """√J2,a + slope · σ_H,max (n,), to be compared with the fatigue limit in torsion."""
        return self.amplitude_MPa + slope * self.hydrostatic_MPa


def smith_watson_topper(history: Array, material: Elastic) -> CriticalPlanes:
    """σ_n,max · Δε_n / 2 (n,) in MPa on the plane where it is largest (Smith, Watson & Topper, J. Materials 5 (1970)
    767). On planes as by Socie, J. Eng. Mater. Technol. 109 (1987) 293; a plane that is never pulled has 0.
    """
    return critical_planes(history, lambda stress, normals: swt_on_planes(stress, normals, material))


def critical_planes(history: Array, on_planes: OnPlanes) -> CriticalPlanes:
    """The planes where a parameter of a history (s, n, 6) is largest, searched in 240 directions spread evenly over a
    hemisphere, and refined about the best one to 0.6°.
    on_planes: from tensors (s, n, 3, 3) and planes (n, k, 3) to the parameter (n, k).
    """
    parts = [_critical(history[:, k : k + _AT_ONCE], on_planes) for k in range(0, max(history.shape[1], 1), _AT_ONCE)]
    return CriticalPlanes(np.concatenate([p for p, _ in parts]), np.concatenate([n for _, n in parts]))


def crossland(history: Array) -> Crossland:
    """Crossland's stresses of a history (s, n, 6): √J2,a is the radius of the smallest ball about the path of the
    deviatoric stress over √2.

    Crossland, Proc. Int. Conf. Fatigue of Metals, 1956; the ball by Badoiu & Clarkson, Comput. Geom. 40 (2008) 14.
    """
    pressure = history[..., :3].mean(axis=-1)
    path = history.copy()
    path[..., :3] -= pressure[..., None]
    # Shears count twice in the norm of the tensor.
    path[..., 3:] *= np.sqrt(2.0)
    return Crossland(_least_radii(path) / np.sqrt(2.0), pressure.max(axis=0))


@compiled
def _least_radii(path: Array) -> Array:
    """Radii (n,) of the smallest balls about n paths (s, n, 6)."""
    radii, centre = np.full(path.shape[1], np.inf), np.zeros(6)
    for point in range(path.shape[1]):
        for c in range(6):
            low, high = np.inf, -np.inf
            for s in range(len(path)):
                low, high = min(low, path[s, point, c]), max(high, path[s, point, c])
            centre[c] = 0.5 * (low + high)
        for k in range(60):
            most, farthest = -1.0, 0
            for s in range(len(path)):
                square = 0.0
                for c in range(6):
                    square += (path[s, point, c] - centre[c]) ** 2
                if square > most:
                    most, farthest = square, s
            radii[point] = min(radii[point], np.sqrt(most))
            for c in range(6):
                centre[c] += (path[farthest, point, c] - centre[c]) / (k + 2.0)
    return radii


def _critical(history: Array, on_planes: OnPlanes) -> tuple[Array, Array]:
    stress = tensors(history)
    # Directions (n, 3) spread evenly over half a sphere, by the golden angle.
    k = np.arange(_DIRECTIONS)
    z = (k + 0.5) / _DIRECTIONS
    angle = np.pi * (3.0 - np.sqrt(5.0)) * k
    r = np.sqrt(1.0 - z**2)
    spread = np.column_stack([r * np.cos(angle), r * np.sin(angle), z])
    values = on_planes(stress, np.broadcast_to(spread, (history.shape[1], *spread.shape)))
    best = values.argmax(axis=1)
    normal, parameter = spread[best], values.max(axis=1)
    for tilt in _TILTS:
        # Eight directions (n, 8, 3) at an angle from each of (n, 3).
        first, second = in_plane(normal)
        turn = np.arange(8) * np.pi / 4.0
        aside = np.cos(turn)[:, None] * first[:, None] + np.sin(turn)[:, None] * second[:, None]
        tried = np.cos(tilt) * normal[:, None] + np.sin(tilt) * aside
        values = on_planes(stress, tried)
        best, found = values.argmax(axis=1), values.max(axis=1)
        better = found > parameter
        normal = np.where(better[:, None], tried[np.arange(len(best)), best], normal)
        parameter = np.maximum(parameter, found)
    return parameter, normal


def swt_on_planes(stress: Array, normals: Array, material: Elastic) -> Array:
    """σ_n,max Δε_n / 2 (n, k) in MPa of tensors (s, n, 3, 3) on planes (n, k, 3); 0 where a plane is never pulled."""
    # In one order of memory: else it would be compiled for each that comes.
    stress, normals = np.ascontiguousarray(stress), np.ascontiguousarray(normals)
    return _swt_on_planes(stress, normals, material.youngs_modulus_MPa, material.poissons_ratio)


@compiled
def _swt_on_planes(stress: Array, normals: Array, modulus_MPa: float, nu: float) -> Array:
    """The parameter (n, k) of `swt_on_planes`."""
    found = np.zeros(normals.shape[:2])
    for n in range(normals.shape[0]):
        for k in range(normals.shape[1]):
            x, y, z = normals[n, k]
            pull, low, high = 0.0, np.inf, -np.inf
            for s in range(len(stress)):
                own = stress[s, n]
                shear = x * y * own[0, 1] + y * z * own[1, 2] + x * z * own[0, 2]
                normal = x * x * own[0, 0] + y * y * own[1, 1] + z * z * own[2, 2] + 2.0 * shear
                strain = (1.0 + nu) * normal - nu * (own[0, 0] + own[1, 1] + own[2, 2])
                pull, low, high = max(pull, normal), min(low, strain), max(high, strain)
            found[n, k] = pull * 0.5 * (high - low) / modulus_MPa
    return found


def normal_stresses(stress: Array, normals: Array) -> Array:
    """Normal stresses (s, n, k), tension positive, of the tensors (s, n, 3, 3) of s states at n points, on k planes
    through each point with the unit normals (n, k, 3).
    """
    squares = (normals[..., None] * normals[..., None, :]).reshape(*normals.shape[:2], 9)
    columns = np.moveaxis(stress.reshape(*stress.shape[:2], 9), 0, 1)
    found: Array = np.moveaxis(columns @ np.swapaxes(squares, 1, 2), 1, 0)
    return found


def stress_vectors(stress: Array, normals: Array) -> Array:
    """Stress vectors (s, n, k, 3), tensor times normal, of the tensors (s, n, 3, 3) of s states at n points, on k
    planes through each point with the unit normals (n, k, 3).
    """
    return np.asarray(np.einsum("snij,nkj->snki", stress, normals, optimize=True))


def in_plane(normal: Array) -> tuple[Array, Array]:
    """Two unit vectors, (..., 3) each, at right angles to each other and to unit normals (..., 3)."""
    helper = np.where(np.abs(normal[..., 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    first = np.cross(normal, helper)
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    return first, np.cross(normal, first)
