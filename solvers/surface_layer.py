"""Layers on a body's surface, such as a coating or a hard skin: how they wear, one after another, and rub.

Of a layer's own stiffness nothing is taken: it is as elastic as the body, and a thin coat on a contact many times as
wide is.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array
from solvers.errors import SolverError
from solvers.local_state import LocalState

# Over the last part of a layer's thickness its friction passes linearly to that of what lies below it.
_FADING = 0.1


@dataclass(frozen=True)
class SurfaceLayer:
    """A layer of even thickness.

    wear_factor: its wear coefficient over that of the body.  friction_factor: friction of the contact where it lies on
    the surface, over that without any layer; None where it is the same.
    Raises SolverError unless thickness and wear factor are positive, and the friction's not negative.
    """

    thickness_mm: float
    wear_factor: float
    friction_factor: float | None = None

    def __post_init__(self) -> None:
        if not (self.thickness_mm > 0.0 and self.wear_factor > 0.0 and (self.friction_factor or 0.0) >= 0.0):
            raise SolverError("a layer has a positive thickness and wear factor, and a friction that is not negative")


Layers = Sequence[SurfaceLayer]  #: Of one body, the outermost first.


def work_through(layers: Layers) -> tuple[Array, Array]:
    """Depths (m + 1,) of m layers' lower faces, the surface first, and how deep the body without layers would be by the
    same wear, both in mm.
    """
    thickness = np.array([0.0, *(layer.thickness_mm for layer in layers)])
    factors = np.array([1.0, *(layer.wear_factor for layer in layers)])
    return np.cumsum(thickness), np.cumsum(thickness / factors)


def bare_depth(layers: Layers, depth: Array) -> Array:
    """How deep the body without layers would be by the wear that has worn it to some depth, in the same unit as that of
    the layers.
    """
    faces, bare = work_through(layers)
    return np.asarray(np.interp(depth, faces, bare) + np.maximum(depth - faces[-1], 0.0))


def receded(layers: Layers, depth_mm: Array, bare_mm: Array) -> Array:
    """By how much surfaces worn to a depth recede where the body without layers would by `bare_mm`; exact."""
    if not layers:
        return bare_mm
    (faces, bare), wanted = work_through(layers), bare_depth(layers, depth_mm) + bare_mm
    return np.asarray(np.interp(wanted, bare, faces) + np.maximum(wanted - bare[-1], 0.0) - depth_mm)


def friction_factor(upper: Layers, lower: Layers, local: LocalState) -> float | Array:
    """Factor on friction by the layers that lie on the surface at k nodes, (k,); where both bodies have one, the mean
    of both.
    """
    if not (upper or lower):
        return 1.0
    layered = [(layers, body_is_upper) for layers, body_is_upper in ((upper, True), (lower, False)) if _rubs(layers)]
    if not layered:
        return 1.0
    more = there = np.zeros(1)
    for layers, body_is_upper in layered:
        primary = body_is_upper == local.primary_is_upper
        depth = local.wear.depths[0 if primary else 1].ravel()
        at = local.of_primary if primary else local.of_secondary
        faces, known = work_through(layers)[0], [layer.friction_factor for layer in layers]
        starts = faces[1:] - _FADING * np.diff(faces)
        places = np.ravel(np.column_stack([starts, faces[1:]]))
        factors = [1.0 if factor is None else factor for factor in (*known, None)]
        own = [0.0 if factor is None else 1.0 for factor in (*known, None)]
        for values, add in ((np.array(factors) - 1.0, True), (np.array(own), False)):
            # From the start of its fading on, a layer gives way to the next one.
            course = np.ravel(np.column_stack([values[:-1], values[1:]]))
            field = at(np.interp(depth, places, course))
            more, there = (more + field, there) if add else (more, there + field)
    return np.asarray(1.0 + more / np.maximum(there, 1.0))


def _rubs(layers: Layers) -> bool:
    return any(layer.friction_factor is not None for layer in layers)
