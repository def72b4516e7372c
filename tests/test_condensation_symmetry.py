"""Bodies that are their own mirror image are condensed by halves or quarters."""

from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from geometry import Cylinder, GradedAxis, HexMesh, PlanarGeometry, QuadMesh, build_planar, mirror_images
from solvers.condensation import CondensedBody, condense
from solvers.elasticity import stiffness_matrix
from solvers.errors import SolverError
from solvers.patch_compliance import PatchCompliance
from solvers.placement import place
from solvers.substructuring import schur_complement
from tests.bodies import STEEL, brick, condensed_wire, patch_on, wire, wire_geometry
from wirewear.simulation import problem as wires

Array = NDArray[np.float64]

FINE_mm = 0.02


def gripped(mesh: HexMesh, *, low: tuple[float, float]) -> HexMesh:
    """The mesh with only those facets of its grip whose centres lie beyond these x and y."""
    centres = mesh.points[mesh.surfaces["grip"]].mean(axis=1)
    chosen = (centres[:, 0] > low[0]) & (centres[:, 1] > low[1])
    return replace(mesh, surfaces=dict(mesh.surfaces) | {"grip": mesh.surfaces["grip"][chosen]})


def by_the_whole(mesh: HexMesh | QuadMesh, body: CondensedBody) -> Array:
    """The compliance of a body from the Schur complement of all of it."""
    kept = body.patch.nodes.ravel()
    inner = np.setdiff1d(np.arange(len(mesh.points)), np.union1d(kept, mesh.surface_nodes("grip")))
    return np.asarray(np.linalg.inv(schur_complement(stiffness_matrix(mesh, STEEL), kept, inner, 3)))


def assert_close(found: Array, expected: Array) -> None:
    assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize(
    ("low", "planes"), [((-1.0, -1.0), (0, 1)), ((0.0, -1.0), (1,)), ((-1.0, 0.0), (0,)), ((0.0, 0.0), ())]
)
def test_the_compliance_by_symmetry_is_that_of_the_whole_body(
    low: tuple[float, float], planes: tuple[int, ...]
) -> None:
    mesh = gripped(brick((4, 8, 3), (1.0, 1.5, 0.7)), low=low)
    body = condense(mesh, patch_on(mesh), STEEL)
    assert body.folded.planes == planes
    assert_close(body.compliance, by_the_whole(mesh, body))
    assert np.array_equal(body.compliance, body.compliance.T)


def test_a_wire_is_a_quarter_condensed_four_times() -> None:
    meshed, body = wire(FINE_mm), condensed_wire(FINE_mm)
    assert body.folded.planes == (0, 1)
    assert body.folded.blocks.size < 0.55 * body.compliance.size
    assert_close(body.compliance, by_the_whole(meshed.mesh, body))


@pytest.mark.parametrize("shape", [(5, 4, 3), (4, 5, 3), (5, 5, 3)])
def test_cells_across_a_plane_forbid_to_cut_there(shape: tuple[int, int, int]) -> None:
    mesh = brick(shape, (1.0, 1.0, 0.7))
    body = condense(mesh, patch_on(mesh), STEEL)
    assert body.folded.planes == tuple(axis for axis in (0, 1) if shape[axis] % 2 == 0)


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


def test_the_same_points_joined_otherwise_are_no_mirror_image() -> None:
    mesh = brick((2, 2, 1), (1.0, 1.0, 0.5))
    assert mirror_images(replace(mesh, cells=mesh.cells[1:]), 0) is None


def test_a_planar_body_is_condensed_by_halves() -> None:
    along = GradedAxis(0.02, 0.1, 0.04, 0.2)
    planar = build_planar(PlanarGeometry(Cylinder(2.0, curved_along=True), 1.0, 1.0, along, 0.2))
    body = condense(planar.mesh, planar.patch, STEEL)
    assert body.folded.planes == (0,)
    assert_close(body.compliance, by_the_whole(planar.mesh, body))


def test_a_wire_worn_alike_on_both_sides_stays_symmetric() -> None:
    fresh = wire(FINE_mm)
    a, t = fresh.patch.axial_mm, fresh.patch.transverse_mm
    depth = 0.004 * np.outer(np.cos(0.5 * pi * a / a[-1]), np.maximum(1.0 - (t / 0.035) ** 2, 0.0))
    noise = 1e-12 * depth.max() * np.random.default_rng(3).uniform(size=depth.shape)
    worn = fresh.worn(depth + noise)
    assert condense(worn.mesh, worn.patch, STEEL).folded.planes == (0, 1)
    lopsided = fresh.worn(depth * (1.0 + 0.1 * (a[:, None] > 0.0)))
    assert condense(lopsided.mesh, lopsided.patch, STEEL).folded.planes == (1,)


def turned_dense(body: CondensedBody, rotation: Array) -> Array:
    n = body.patch.size
    blocks = body.compliance.reshape(n, 3, n, 3)
    turned: Array = np.einsum("ak,ikjl,bl->iajb", rotation, blocks, rotation)
    return turned.reshape(3 * n, 3 * n)


@pytest.mark.parametrize("degrees", [0.0, 90.0, 35.0])
@pytest.mark.parametrize("upper", [False, True])
def test_a_placed_body_has_the_turned_compliance(degrees: float, upper: bool) -> None:
    body = condensed_wire(FINE_mm)
    placed = place(body, upper=upper, axis_angle_rad=np.radians(degrees))
    assert_close(placed.compliance, turned_dense(body, placed.folded.rotation))
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


def test_parts_of_a_wrong_size_are_refused() -> None:
    with pytest.raises(SolverError, match=r"mirror planes \(0,\) has no compliance of shape"):
        PatchCompliance((3, 1), (0,), np.zeros((2, 9, 9)))


def test_a_wire_comes_back_from_the_cache_as_it_was_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    geometry = wire_geometry(FINE_mm, 0.02, 0.04)
    made = wires.condensed_wire(geometry, STEEL, tmp_path)

    def forbidden(*_: object) -> None:
        raise AssertionError("the wire was condensed again")

    monkeypatch.setattr(wires, "condense", forbidden)
    kept = wires.condensed_wire(geometry, STEEL, tmp_path)
    assert np.array_equal(kept.compliance, made.compliance)
    assert np.array_equal(kept.patch.nodes, made.patch.nodes)
