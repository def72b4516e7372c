"""Condensation of a body onto its contact patch."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.sparse import block_diag, csr_matrix, diags, eye, kron
from scipy.sparse.linalg import splu

from geometry import GeometryError, HexMesh
from solvers.condensation import CondensedBody, condense
from solvers.elasticity import stiffness_matrix
from solvers.errors import SolverError
from solvers.substructuring import schur_complement
from tests.bodies import STEEL, brick, patch_on

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


@pytest.fixture(scope="module")
def block() -> HexMesh:
    return brick((8, 7, 6), (1.0, 0.9, 0.7), distortion=0.2)


@pytest.fixture(scope="module")
def body(block: HexMesh) -> CondensedBody:
    return condense(block, patch_on(block), STEEL)


def test_the_compliance_is_that_of_the_full_body_solved_directly(block: HexMesh, body: CondensedBody) -> None:
    free = np.setdiff1d(np.arange(len(block.points)), block.surface_nodes("grip"))
    unknowns = (3 * free[:, None] + np.arange(3)).ravel()
    matrix = stiffness_matrix(block, STEEL).tocsc()[unknowns][:, unknowns]
    rows = (3 * np.searchsorted(free, body.patch.nodes.ravel())[:, None] + np.arange(3)).ravel()
    loads = np.zeros((len(unknowns), len(rows)))
    loads[rows, np.arange(len(rows))] = 1.0
    direct = splu(matrix.tocsc()).solve(loads)[rows]
    assert np.abs(body.compliance - direct).max() < 1e-10 * np.abs(direct).max()


def test_the_compliance_is_symmetric_and_positive_definite(body: CondensedBody) -> None:
    assert np.array_equal(body.compliance, body.compliance.T)
    assert np.linalg.eigvalsh(body.compliance).min() > 0.0


def test_a_patch_that_touches_the_grip_is_refused(block: HexMesh) -> None:
    with pytest.raises(SolverError, match="grips nodes of the contact patch"):
        condense(block, patch_on(block), STEEL, grip="top")


def test_a_body_that_nothing_holds_is_refused(block: HexMesh) -> None:
    surfaces = dict(block.surfaces) | {"grip": np.empty((0, 4), dtype=np.int64)}
    with pytest.raises(SolverError, match="nothing holds the body"):
        condense(dataclasses.replace(block, surfaces=surfaces), patch_on(block), STEEL)


def test_an_unknown_grip_is_named(block: HexMesh) -> None:
    with pytest.raises(GeometryError, match="no surface 'back'"):
        condense(block, patch_on(block), STEEL, grip="back")


def test_a_body_of_which_only_a_part_is_held_is_refused(block: HexMesh) -> None:
    loose = len(block.points)
    points = np.vstack([block.points, block.points + [5.0, 0.0, 0.0]])
    two = HexMesh(points, np.vstack([block.cells, block.cells + loose]), block.surfaces)
    with pytest.raises(SolverError, match="grip does not hold"):
        condense(two, patch_on(block), STEEL)


def test_a_single_layer_between_grip_and_patch_needs_no_elimination() -> None:
    layer = brick((4, 4, 1), (1.0, 1.0, 0.2))
    body = condense(layer, patch_on(layer), STEEL)
    top = (3 * body.patch.nodes.ravel()[:, None] + np.arange(3)).ravel()
    stiffness = stiffness_matrix(layer, STEEL)[top][:, top].toarray()
    assert body.compliance @ stiffness == pytest.approx(np.eye(len(top)), abs=1e-10)


def laplacian(n: int) -> csr_matrix:
    line = diags([-np.ones(n - 1), 2.0 * np.ones(n), -np.ones(n - 1)], [-1, 0, 1])
    one = eye(n)
    return (kron(kron(line, one), one) + kron(kron(one, line), one) + kron(kron(one, one), line)).tocsr()


def dense_schur_complement(matrix: csr_matrix, kept: IntArray, eliminated: IntArray) -> Array:
    full = matrix.toarray()
    coupling = full[np.ix_(eliminated, kept)]
    inner = full[np.ix_(eliminated, eliminated)]
    return np.asarray(full[np.ix_(kept, kept)] - coupling.T @ np.linalg.solve(inner, coupling))


@settings(max_examples=8)
@given(st.integers(0, 2**32 - 1), st.floats(0.01, 0.5), st.floats(0.0, 0.3))
def test_nested_substructures_give_the_dense_schur_complement(seed: int, kept_share: float, held_share: float) -> None:
    rng = np.random.default_rng(seed)
    matrix = laplacian(7)
    nodes = rng.permutation(343).astype(np.int64)
    kept_count = max(1, int(kept_share * 343))
    kept, eliminated = nodes[:kept_count], np.sort(nodes[kept_count + int(held_share * 343) :])
    found = schur_complement(matrix, kept, eliminated, 1)
    assert found == pytest.approx(dense_schur_complement(matrix, kept, eliminated), abs=1e-12)


def test_unconnected_parts_are_condensed_together() -> None:
    matrix = block_diag([laplacian(7), laplacian(7)]).tocsr()
    kept = np.array([0, 340, 400], dtype=np.int64)
    eliminated = np.setdiff1d(np.arange(686), kept)
    found = schur_complement(matrix, kept, eliminated, 1)
    assert found == pytest.approx(dense_schur_complement(matrix, kept, eliminated), abs=1e-12)
