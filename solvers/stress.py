"""What is made of a stress: invariants, principal values, turned axes. Stresses are (..., 6) as in VTK."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from solvers.strain import components, tensors

Array = NDArray[np.float64]


def von_mises(stress: Array) -> Array:
    """Von Mises' equivalent stress (...), √(3 J2)."""
    xx, yy, zz, xy, yz, xz = np.moveaxis(stress, -1, 0)
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.asarray(np.sqrt(0.5 * normal + 3.0 * (xy**2 + yz**2 + xz**2)))


def principal(stress: Array) -> Array:
    """Principal stresses (..., 3), the largest first."""
    return np.asarray(np.linalg.eigvalsh(tensors(stress))[..., ::-1])


def tresca(stress: Array) -> Array:
    """Tresca's equivalent stress (...), the largest less the smallest principal stress."""
    values = principal(stress)
    return np.asarray(values[..., 0] - values[..., 2])


def hydrostatic(stress: Array) -> Array:
    """Mean normal stress (...)."""
    return np.asarray(stress[..., :3].mean(axis=-1))


def turned(stress: Array, rotation: Array) -> Array:
    """The same stresses in axes into which the matrix (3, 3) turns vectors."""
    return components(rotation @ tensors(stress) @ rotation.T)
