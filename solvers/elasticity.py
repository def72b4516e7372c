"""Linear elasticity on eight-node bricks with full (2 x 2 x 2) integration, assembled by scikit-fem."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import bmat, csr_matrix
from skfem import Basis, BilinearForm, ElementHex1, MeshHex
from skfem.models.elasticity import lame_parameters

from geometry import HexMesh
from solvers.errors import SolverError

# scikit-fem numbers the corners of a hexahedron differently from VTK.
_SKFEM_CORNERS = [0, 4, 3, 1, 7, 5, 2, 6]


@dataclass(frozen=True)
class Elastic:
    """An isotropic linear elastic material."""

    youngs_modulus_MPa: float
    poissons_ratio: float

    def __post_init__(self) -> None:
        if not self.youngs_modulus_MPa > 0.0:
            raise SolverError(f"Young's modulus must be positive, but is {self.youngs_modulus_MPa} MPa")
        if not 0.0 <= self.poissons_ratio < 0.5:
            raise SolverError(f"Poisson's ratio must lie in 0 ... 0.5 (0.5 excluded), but is {self.poissons_ratio}")


def stiffness_matrix(mesh: HexMesh, material: Elastic) -> csr_matrix:
    """Stiffness in N/mm, shape (3 n, 3 n); the displacement of node i in direction k is unknown 3 i + k.

    Assembled from the scalar forms G_ab = integral of (d phi_i / d x_a)(d phi_j / d x_b), which is several times
    faster than the vector form: the block of directions a, b is lambda G_ab + mu G_ba + delta_ab mu trace(G).
    """
    corners = np.ascontiguousarray(mesh.cells.T[_SKFEM_CORNERS])
    skfem_mesh = MeshHex(np.ascontiguousarray(mesh.points.T), corners, sort_t=False, validate=False)
    basis = Basis(skfem_mesh, ElementHex1(), intorder=3)
    lame_lambda, shear = lame_parameters(material.youngs_modulus_MPa, material.poissons_ratio)
    gradients = {
        (a, b): BilinearForm(lambda u, v, _, a=a, b=b: v.grad[a] * u.grad[b]).assemble(basis)
        for a in range(3)
        for b in range(a, 3)
    }
    gradients |= {(b, a): gradients[a, b].T for a in range(3) for b in range(a + 1, 3)}
    laplacian = gradients[0, 0] + gradients[1, 1] + gradients[2, 2]
    blocks = [[lame_lambda * gradients[a, b] + shear * gradients[b, a] for b in range(3)] for a in range(3)]
    for a in range(3):
        blocks[a][a] = blocks[a][a] + shear * laplacian
    # Unknowns by direction, then interleaved node by node.
    n = len(mesh.points)
    order = np.arange(3 * n).reshape(3, n).T.ravel()
    return bmat(blocks, format="csr")[order][:, order]
