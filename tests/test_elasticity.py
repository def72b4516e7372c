"""The stiffness matrix of a body of eight-node bricks."""

import numpy as np
import pytest
from numpy.typing import NDArray
from skfem import Basis, ElementHex1, ElementVector, MeshHex
from skfem.models.elasticity import lame_parameters, linear_elasticity

from geometry import Elastic, HexMesh
from solvers.elasticity import stiffness_matrix
from solvers.errors import SolverError
from tests.bodies import brick

Array = NDArray[np.float64]

MATERIAL = Elastic(210_000.0, 0.3)


@pytest.fixture(scope="module")
def mesh() -> HexMesh:
    return brick((3, 4, 5), (1.0, 1.5, 2.0), distortion=0.25)


def energy(mesh: HexMesh, displacement: Array) -> float:
    u = displacement.ravel()
    return 0.5 * float(u @ (stiffness_matrix(mesh, MATERIAL) @ u))


def test_translations_and_rotations_store_no_energy(mesh: HexMesh) -> None:
    matrix = stiffness_matrix(mesh, MATERIAL)
    scale = abs(matrix).max()
    for k in range(3):
        translation = np.zeros_like(mesh.points)
        translation[:, k] = 1.0
        rotation = np.cross(np.eye(3)[k], mesh.points)
        for motion in (translation, rotation):
            assert np.abs(matrix @ motion.ravel()).max() < 1e-12 * scale


def test_uniaxial_tension_stores_the_exact_energy_on_a_distorted_mesh(mesh: HexMesh) -> None:
    strain = 1e-3
    stretch = np.diag([strain, -MATERIAL.poissons_ratio * strain, -MATERIAL.poissons_ratio * strain])
    exact = 0.5 * MATERIAL.youngs_modulus_MPa * strain**2 * mesh.volume_mm3()
    assert energy(mesh, mesh.points @ stretch) == pytest.approx(exact, rel=1e-12)


def test_simple_shear_stores_the_exact_energy_on_a_distorted_mesh(mesh: HexMesh) -> None:
    angle, shear_modulus = 1e-3, MATERIAL.youngs_modulus_MPa / (2.0 * (1.0 + MATERIAL.poissons_ratio))
    displacement = np.zeros_like(mesh.points)
    displacement[:, 1] = angle * mesh.points[:, 2]
    exact = 0.5 * shear_modulus * angle**2 * mesh.volume_mm3()
    assert energy(mesh, displacement) == pytest.approx(exact, rel=1e-12)


def test_a_uniform_strain_leaves_inner_nodes_in_equilibrium(mesh: HexMesh) -> None:
    strain = np.random.default_rng(3).normal(size=(3, 3))
    forces = (stiffness_matrix(mesh, MATERIAL) @ (mesh.points @ strain).ravel()).reshape(-1, 3)
    inner = np.setdiff1d(np.arange(len(mesh.points)), np.unique(mesh.boundary_facets()))
    assert np.abs(forces[inner]).max() < 1e-12 * np.abs(forces).max()


def test_the_matrix_equals_the_vector_form_of_scikit_fem(mesh: HexMesh) -> None:
    skfem_mesh = MeshHex(mesh.points.T.copy(), mesh.cells.T[[0, 4, 3, 1, 7, 5, 2, 6]].copy(), sort_t=False)
    basis = Basis(skfem_mesh, ElementVector(ElementHex1()), intorder=3)
    lame = lame_parameters(MATERIAL.youngs_modulus_MPa, MATERIAL.poissons_ratio)
    reference = linear_elasticity(*lame).assemble(basis)
    nodal = basis.nodal_dofs.T.ravel()
    difference = stiffness_matrix(mesh, MATERIAL) - reference[nodal][:, nodal]
    assert abs(difference).max() < 1e-12 * abs(reference).max()


def test_the_matrix_is_symmetric(mesh: HexMesh) -> None:
    matrix = stiffness_matrix(mesh, MATERIAL)
    assert abs(matrix - matrix.T).max() < 1e-14 * abs(matrix).max()


def test_an_incompressible_body_is_refused(mesh: HexMesh) -> None:
    with pytest.raises(SolverError, match=r"Poisson's ratio must be below 0\.5"):
        stiffness_matrix(mesh, Elastic(1.0, 0.5))
