"""Condensation of a body onto its contact patch."""

import dataclasses
from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_matrix, diags, eye, kron
from scipy.sparse.linalg import splu
from skfem import Basis, ElementHex1, ElementVector, MeshHex
from skfem.models.elasticity import lame_parameters, linear_elasticity

from geometry import Elastic, Flat, GradedAxis, HexMesh, PlanarGeometry, QuadMesh, build_planar, mirror_images
from geometry.arrays import Array, IntArray
from solvers import CondensedBody, SolverError, condense, place
from solvers.elasticity.elimination import _separator, divided, node_graph, schur_complements
from solvers.elasticity.linear_elasticity import stiffness_matrix
from tests.bodies import STEEL, brick, condensed_wire, patch_on, wire, wire_geometry
from wirewear.simulation import problem as wires

MATERIAL = Elastic(210_000.0, 0.3)
FINE_mm = 0.02


@pytest.fixture(scope="module")
def mesh() -> HexMesh:
    return brick((3, 4, 5), (1.0, 1.5, 2.0), distortion=0.25)


def test_the_matrix_equals_the_vector_form_of_scikit_fem(mesh: HexMesh) -> None:
    skfem_mesh = MeshHex(mesh.points.T.copy(), mesh.cells.T[[0, 4, 3, 1, 7, 5, 2, 6]].copy(), sort_t=False)
    basis = Basis(skfem_mesh, ElementVector(ElementHex1()), intorder=3)
    lame = lame_parameters(MATERIAL.youngs_modulus_MPa, MATERIAL.poissons_ratio)
    reference = linear_elasticity(*lame).assemble(basis)
    nodal = basis.nodal_dofs.T.ravel()
    difference = stiffness_matrix(mesh, MATERIAL) - reference[nodal][:, nodal]
    assert abs(difference).max() < 1e-12 * abs(reference).max()


def gripped(mesh: HexMesh, *, low: tuple[float, float]) -> HexMesh:
    """The mesh with only those facets of its grip whose centres lie beyond these x and y."""
    centres = mesh.points[mesh.surfaces["grip"]].mean(axis=1)
    chosen = (centres[:, 0] > low[0]) & (centres[:, 1] > low[1])
    return replace(mesh, surfaces=dict(mesh.surfaces) | {"grip": mesh.surfaces["grip"][chosen]})


def by_the_whole(mesh: HexMesh | QuadMesh, body: CondensedBody) -> Array:
    """The compliance of a body from the Schur complement of all of it."""
    kept = body.patch.nodes.ravel()
    inner = np.setdiff1d(np.arange(len(mesh.points)), np.union1d(kept, mesh.surface_nodes("grip")))
    matrix = stiffness_matrix(mesh, STEEL)
    return np.asarray(np.linalg.inv(*schur_complements(matrix, kept, inner, 3, np.zeros((1, matrix.shape[0]), bool))))


def assert_close(found: Array, expected: Array) -> None:
    assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize(
    ("low", "planes"), [((-1.0, -1.0), (0, 1)), ((0.0, -1.0), (1,)), ((-1.0, 0.0), (0,)), ((0.0, 0.0), ())]
)
def test_a_compliance_by_symmetry_is_that_of_the_whole_body(low: tuple[float, float], planes: tuple[int, ...]) -> None:
    mesh = gripped(brick((4, 8, 3), (1.0, 1.5, 0.7)), low=low)
    body = condense(mesh, patch_on(mesh), STEEL)
    assert body.folded.planes == planes
    assert_close(body.compliance, by_the_whole(mesh, body))
    assert np.array_equal(body.compliance, body.compliance.T)


@pytest.mark.seconds
def test_a_wire_is_a_quarter_condensed_four_times() -> None:
    meshed, body = wire(FINE_mm), condensed_wire(FINE_mm)
    assert body.folded.planes == (0, 1)
    assert body.folded.blocks.size < 0.55 * body.compliance.size
    assert_close(body.compliance, by_the_whole(meshed.mesh, body))


def test_a_node_out_of_place_by_the_last_bit_breaks_the_symmetry() -> None:
    mesh = brick((4, 4, 2), (1.0, 1.0, 0.5))
    points = mesh.points.copy()
    inner = int(np.argmin(np.linalg.norm(points - [0.25, 0.25, -0.25], axis=1)))
    points[inner, 2] = np.nextafter(points[inner, 2], 0.0)
    for axis in (0, 1):
        images = mirror_images(mesh, axis)
        assert images is not None
        assert np.array_equal(images[images], np.arange(len(points)))
        assert mirror_images(replace(mesh, points=points), axis) is None


@pytest.mark.seconds
def test_a_wire_worn_alike_on_both_sides_stays_symmetric() -> None:
    fresh = wire(FINE_mm)
    a, t = fresh.patch.axial_mm, fresh.patch.transverse_mm
    depth = 0.004 * np.outer(np.cos(0.5 * pi * a / a[-1]), np.maximum(1.0 - (t / 0.035) ** 2, 0.0))
    noise = 1e-12 * depth.max() * np.random.default_rng(3).uniform(size=depth.shape)
    worn = fresh.worn(depth + noise)
    assert condense(worn.mesh, worn.patch, STEEL).folded.planes == (0, 1)
    lopsided = fresh.worn(depth * (1.0 + 0.1 * (a[:, None] > 0.0)))
    assert condense(lopsided.mesh, lopsided.patch, STEEL).folded.planes == (1,)


def test_a_body_is_divided_once_however_it_wears() -> None:
    fresh = brick((8, 6, 6), (1.0, 0.8, 0.7))
    worn = replace(fresh, points=fresh.points * [1.0, 1.0, 0.9])
    trees = [divided(node_graph(stiffness_matrix(one, STEEL), 3), np.arange(250)) for one in (fresh, worn)]
    assert trees[0] is trees[1]
    assert divided(node_graph(stiffness_matrix(worn, STEEL), 3), np.arange(249)) is not trees[0]


@pytest.mark.seconds
@pytest.mark.parametrize("degrees", [0.0, 90.0, 35.0])
@pytest.mark.parametrize("upper", [False, True])
def test_a_placed_body_has_the_turned_compliance(degrees: float, upper: bool) -> None:
    body = condensed_wire(FINE_mm)
    placed = place(body, upper=upper, axis_angle_rad=np.radians(degrees))
    n, rotation = body.patch.size, placed.folded.rotation
    turned = np.einsum("ak,ikjl,bl->iajb", rotation, body.compliance.reshape(n, 3, n, 3), rotation)
    assert_close(placed.compliance, turned.reshape(3 * n, 3 * n))
    assert placed.folded.diagonal() == pytest.approx(placed.compliance.diagonal(), rel=1e-12)
    position = placed.node_positions
    local = np.column_stack([body.patch.grid(), np.zeros(len(position))]) @ placed.folded.rotation.T
    assert position == pytest.approx(local[:, :2], abs=1e-15)


@pytest.mark.parametrize("degrees", [90.0, 35.0])
def test_what_is_gathered_between_nodes_is_that_part_of_the_whole(degrees: float) -> None:
    folded = place(condensed_wire(FINE_mm), upper=True, axis_angle_rad=np.radians(degrees)).folded
    rng = np.random.default_rng(2)
    moved, loaded = (rng.permutation(25)[:count] for count in (7, 11))
    rows, columns = ((3 * nodes[:, None] + np.arange(3)).ravel() for nodes in (moved, loaded))
    assert np.array_equal(folded.between(moved, loaded), folded.dense[np.ix_(rows, columns)])
    assert folded.between(moved, loaded[:0]).shape == (21, 0)


@pytest.mark.seconds
def test_a_wire_comes_back_from_the_cache_as_it_was_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    geometry = wire_geometry(FINE_mm, 0.02, 0.04)
    made = wires.condensed_body(geometry, STEEL, tmp_path)

    def forbidden(*_: object) -> None:
        raise AssertionError("the wire was condensed again")

    monkeypatch.setattr(wires, "condense_meshed", forbidden)
    kept = wires.condensed_body(geometry, STEEL, tmp_path)
    assert np.array_equal(kept.compliance, made.compliance)
    assert np.array_equal(kept.patch.nodes, made.patch.nodes)


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


def test_a_body_that_nothing_holds_or_of_which_a_part_is_not_held_is_refused(block: HexMesh) -> None:
    surfaces = dict(block.surfaces) | {"grip": np.empty((0, 4), dtype=np.int64)}
    with pytest.raises(SolverError, match="nothing holds the body"):
        condense(dataclasses.replace(block, surfaces=surfaces), patch_on(block), STEEL)
    loose = len(block.points)
    points = np.vstack([block.points, block.points + [5.0, 0.0, 0.0]])
    two = HexMesh(points, np.vstack([block.cells, block.cells + loose]), block.surfaces)
    with pytest.raises(SolverError, match="grip does not hold"):
        condense(two, patch_on(block), STEEL)


def dense_schur_complement(matrix: csr_matrix, kept: IntArray, eliminated: IntArray) -> Array:
    full = matrix.toarray()
    coupling = full[np.ix_(eliminated, kept)]
    inner = full[np.ix_(eliminated, eliminated)]
    return np.asarray(full[np.ix_(kept, kept)] - coupling.T @ np.linalg.solve(inner, coupling))


@pytest.mark.seconds
@settings(max_examples=8)
@given(st.integers(0, 2**32 - 1), st.floats(0.01, 0.5), st.floats(0.0, 0.3))
def test_nested_substructures_give_the_dense_schur_complement(seed: int, kept_share: float, held_share: float) -> None:
    rng = np.random.default_rng(seed)
    line, one = diags([-np.ones(6), 2.0 * np.ones(7), -np.ones(6)], [-1, 0, 1]), eye(7)
    matrix = (kron(kron(line, one), one) + kron(kron(one, line), one) + kron(kron(one, one), line)).tocsr()
    nodes = rng.permutation(343).astype(np.int64)
    kept_count = max(1, int(kept_share * 343))
    kept, eliminated = nodes[:kept_count], np.sort(nodes[kept_count + int(held_share * 343) :])
    found = schur_complements(matrix, kept, eliminated, 1, np.zeros((1, matrix.shape[0]), bool))[0]
    assert found == pytest.approx(dense_schur_complement(matrix, kept, eliminated), abs=1e-12)


def test_substructures_are_parted_by_no_more_nodes_than_either_side_shows(block: HexMesh) -> None:
    graph = node_graph(stiffness_matrix(block, STEEL), 3)
    rng = np.random.default_rng(0)
    fewer = 0
    for _ in range(5):
        # A ragged cut, as bisections of large meshes are.
        second = block.points[:, 0] + rng.uniform(-0.2, 0.2, len(block.points)) * np.ptp(block.points[:, 0]) > 0.0
        separator = _separator(graph, second)
        assert not graph[~second & ~separator][:, second & ~separator].nnz
        rims = [
            int((graph[own][:, other].sum(axis=1) > 0).sum()) for own, other in ((second, ~second), (~second, second))
        ]
        assert separator.sum() <= min(rims)
        fewer += separator.sum() < min(rims)
    assert fewer == 5


@pytest.mark.parametrize("axis_mm", [-10.0, 10.0])
def test_a_ring_widens_as_lame_and_twists_as_saint_venant_say(axis_mm: float) -> None:
    """A solid shaft, and a hub of twice its radius: far from the held end, under even pressure and even turning."""
    half, radius = 15.0, 10.0
    lines = GradedAxis(0.2, half - 0.01, 0.2, half - 0.01)
    ring = build_planar(PlanarGeometry(Flat(), half, 10.0, lines, growth=1.2, axis_mm=axis_mm))
    compliance = condense(ring.mesh, ring.patch, STEEL).compliance
    moved = [compliance[:, k::3] @ ring.patch.node_areas() for k in (1, 2)]
    middle = ring.patch.size // 2
    inner, outer = (0.0, radius) if axis_mm < 0.0 else (radius, 2.0 * radius)
    widened = (outer**2 + radius**2) / (outer**2 - radius**2) + 0.3 if inner else 0.7
    assert moved[1][3 * middle + 2] == pytest.approx(widened * radius / STEEL.youngs_modulus_MPa, rel=2e-3)
    # From the free end the torque grows as 2 pi r^2 x.
    turned = np.gradient(moved[0][1::3], ring.patch.axial_mm)[middle] / radius
    polar = 0.5 * np.pi * (outer**4 - inner**4)
    torque = 2.0 * np.pi * radius**2 * half
    assert abs(turned) == pytest.approx(torque / (STEEL.shear_modulus_MPa * polar), rel=1e-2)
