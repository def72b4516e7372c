"""Linear elasticity on eight-node bricks and four-node quadrilaterals, fully integrated, assembled by scikit-fem.

A planar body does not change along y. Its displacements in the plane (plane strain) and out of it (antiplane shear)
decouple, and both follow from the same formula as a brick's with all derivatives along y zero. It has three unknowns
per node as a brick has.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import bmat, csr_matrix

from geometry import Elastic, HexMesh, QuadMesh
from solvers.errors import SolverError

if TYPE_CHECKING:
    from skfem import Basis

# scikit-fem numbers the corners of a hexahedron differently from VTK.
_SKFEM_CORNERS = [0, 4, 3, 1, 7, 5, 2, 6]


def stiffness_matrix(mesh: HexMesh | QuadMesh, material: Elastic) -> csr_matrix:
    """Stiffness in N/mm (of a planar body per mm of thickness), shape (3 n, 3 n).

    The displacement of node i in direction k is unknown 3 i + k. SolverError for an incompressible material, which has
    no stiffness in displacements alone.
    Assembled from the scalar forms G_ab = integral of (d phi_i / d x_a)(d phi_j / d x_b), which is several times
    faster than the vector form: the block of directions a, b is lambda G_ab + mu G_ba + delta_ab mu trace(G).
    """
    if material.poissons_ratio == 0.5:
        raise SolverError("Poisson's ratio must be below 0.5: incompressible bodies cannot be condensed")
    from skfem import BilinearForm
    from skfem.models.elasticity import lame_parameters

    basis, axes = _basis(mesh)
    lame_lambda, shear = lame_parameters(material.youngs_modulus_MPa, material.poissons_ratio)
    n = len(mesh.points)
    gradients = {(a, b): csr_matrix((n, n)) for a in range(3) for b in range(3)}
    for i, a in enumerate(axes):
        for j, b in list(enumerate(axes))[i:]:
            form = BilinearForm(lambda u, v, _, i=i, j=j: v.grad[i] * u.grad[j]).assemble(basis)
            gradients[a, b] = form
            gradients[b, a] = form if a == b else form.T
    laplacian = gradients[0, 0] + gradients[1, 1] + gradients[2, 2]
    blocks = [[lame_lambda * gradients[a, b] + shear * gradients[b, a] for b in range(3)] for a in range(3)]
    for a in range(3):
        blocks[a][a] = blocks[a][a] + shear * laplacian
    # Unknowns by direction, then interleaved node by node.
    order = np.arange(3 * n).reshape(3, n).T.ravel()
    return bmat(blocks, format="csr")[order][:, order]


def _basis(mesh: HexMesh | QuadMesh) -> tuple[Basis, tuple[int, ...]]:
    """Shape functions with quadrature, and the directions in which they vary."""
    from skfem import Basis, ElementHex1, ElementQuad1, MeshHex, MeshQuad

    points = np.ascontiguousarray(mesh.points.T)
    if isinstance(mesh, QuadMesh):
        quads = MeshQuad(points, np.ascontiguousarray(mesh.cells.T), sort_t=False, validate=False)
        return Basis(quads, ElementQuad1(), intorder=3), (0, 2)
    bricks = MeshHex(points, np.ascontiguousarray(mesh.cells.T[_SKFEM_CORNERS]), sort_t=False, validate=False)
    return Basis(bricks, ElementHex1(), intorder=3), (0, 1, 2)
