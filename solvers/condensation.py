"""Static condensation of an elastic body onto the nodes of its contact patch.

The body is held at its grip. Contact is the only non-linearity, so nothing is lost when all other unknowns are
eliminated once: a force f on the patch's nodes moves them by u = C f relative to the grip, with the dense compliance
C = S^-1 and S the Schur complement of the stiffness matrix.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack
from threadpoolctl import threadpool_limits

from geometry import ContactPatch, HexMesh, QuadMesh
from solvers.elasticity import Elastic, stiffness_matrix
from solvers.errors import SolverError
from solvers.substructuring import cholesky_factor, schur_complement

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CondensedBody:
    """A body reduced to its contact patch.

    compliance: (3 n, 3 n) in mm/N (of a planar body in mm per N/mm), symmetric positive definite; unknown 3 i + k is
    the displacement of patch node i (in the order of patch.nodes.ravel()) along the body's axis k, relative to the
    grip.
    """

    patch: ContactPatch
    compliance: Array


def condense(mesh: HexMesh | QuadMesh, patch: ContactPatch, material: Elastic, grip: str = "grip") -> CondensedBody:
    """Condense a body held at its surface `grip`.

    SolverError when nothing is gripped or the patch touches the grip; GeometryError when there is no such surface.
    """
    held = mesh.surface_nodes(grip)
    if not held.size:
        raise SolverError(f"the surface '{grip}' is empty, so nothing holds the body; make the grip larger")
    contact = patch.nodes.ravel()
    if np.intersect1d(held, contact).size:
        raise SolverError("the holder grips nodes of the contact patch; make the grip or the patch smaller")
    inner = np.setdiff1d(np.arange(len(mesh.points)), np.concatenate([held, contact]))
    # Most fronts are small; on a busy machine, threads that wait for each other would cost ten times what they gain.
    with threadpool_limits(limits=1, user_api="blas"):
        schur = schur_complement(stiffness_matrix(mesh, material), contact, inner, 3)
    return CondensedBody(patch, _inverse(schur))


def _inverse(matrix: Array) -> Array:
    inverse, _ = lapack.dpotri(cholesky_factor(matrix), lower=1, overwrite_c=1)
    return np.asarray(np.tril(inverse) + np.tril(inverse, -1).T)
