"""Surface nodes moved into the worn surface, and the body condensed again."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from geometry import GeometryError, WireMesh
from geometry.mesh_motion import lowered
from solvers.placement import place
from tests import bodies
from tests.bodies import STEEL, brick, wire, wire_geometry
from wirewear.simulation.problem import condensed_wire, condensed_worn_wire

Array = NDArray[np.float64]

FINE_mm = 0.010


@pytest.fixture(scope="module")
def fresh() -> WireMesh:
    return wire(FINE_mm)


def scar(of: WireMesh, deepest_mm: float) -> Array:
    a, t = of.patch.axial_mm / 0.035, of.patch.transverse_mm / 0.035
    return np.asarray(deepest_mm * np.outer(np.maximum(1.0 - a**2, 0.0), np.maximum(1.0 - t**2, 0.0)))


def test_the_volume_of_the_body_shrinks_by_the_worn_volume(fresh: WireMesh) -> None:
    depth = scar(fresh, 0.008)
    worn = fresh.worn(depth)
    lost = fresh.mesh.volume_mm3() - worn.mesh.volume_mm3()
    assert lost == pytest.approx(float(depth.ravel() @ fresh.patch.node_areas()), rel=1e-9)


def test_the_patch_describes_the_moved_nodes_and_nothing_else_of_the_boundary_moves(fresh: WireMesh) -> None:
    worn = fresh.worn(scar(fresh, 0.008))
    points = worn.mesh.points[worn.patch.nodes.ravel()]
    assert points[:, :2] == pytest.approx(worn.patch.grid(), abs=1e-12)
    assert points[:, 2] == pytest.approx(worn.patch.height(worn.patch.grid()), abs=1e-12)
    other = np.setdiff1d(np.unique(fresh.mesh.boundary_facets()), fresh.patch.nodes)
    assert np.array_equal(worn.mesh.points[other], fresh.mesh.points[other])


@pytest.mark.parametrize("deepest_mm", [0.001, 0.008, 0.015])
def test_every_element_stays_sound_and_the_worst_is_reported(fresh: WireMesh, deepest_mm: float) -> None:
    worn = fresh.worn(scar(fresh, deepest_mm))
    assert worn.smallest_scaled_jacobian == pytest.approx(worn.mesh.scaled_jacobians().min())
    assert worn.smallest_scaled_jacobian > 0.2


def test_a_motion_that_folds_elements_is_refused_with_their_place(fresh: WireMesh) -> None:
    depth = np.zeros(fresh.patch.shape)
    depth[4, 4] = 0.1
    with pytest.raises(GeometryError, match=r"the element at \(.*\) mm has a scaled Jacobian of -?\d"):
        fresh.worn(depth)


def test_a_uniform_depth_moves_the_inside_down_by_no_more_than_the_surface() -> None:
    block = brick((6, 6, 6), (0.3, 0.3, 0.3))
    depth = np.full(len(block.surface_nodes("top")), 0.02)
    drop = block.points[:, 2] - lowered(block, block.surface_nodes("top"), depth).points[:, 2]
    assert drop.min() >= 0.0
    assert drop.max() == pytest.approx(0.02)
    column = (np.abs(block.points[:, 0]) < 1e-9) & (np.abs(block.points[:, 1]) < 1e-9)
    assert np.all(np.diff(drop[column][np.argsort(block.points[column, 2])]) > 0.0)


@pytest.mark.parametrize(("depth", "complaint"), [(np.zeros((2, 2)), "does not belong"), (None, "not below zero")])
def test_what_is_no_depth_of_the_patch_is_refused(fresh: WireMesh, depth: Array | None, complaint: str) -> None:
    with pytest.raises(GeometryError, match=complaint):
        fresh.worn(np.full(fresh.patch.shape, -1e-3) if depth is None else depth)


def test_two_motions_leave_the_surface_of_their_sum(fresh: WireMesh) -> None:
    depth = scar(fresh, 0.004)
    twice, once = fresh.worn(depth).worn(depth), fresh.worn(2.0 * depth)
    nodes = fresh.patch.nodes.ravel()
    assert twice.mesh.points[nodes] == pytest.approx(once.mesh.points[nodes], abs=1e-15)
    assert np.array_equal(twice.patch.height(fresh.patch.grid()), once.patch.height(fresh.patch.grid()))


@pytest.mark.parametrize("upper", [True, False])
def test_a_placed_body_sees_the_same_surface_whether_nodes_have_been_moved_into_it_or_not(
    fresh: WireMesh, upper: bool
) -> None:
    depth = scar(fresh, 0.008)
    body = place(bodies.condensed_wire(FINE_mm), upper=upper, axis_angle_rad=0.7)
    moved = replace(body, patch=fresh.worn(depth).patch)
    assert np.array_equal(moved.node_heights(depth), body.node_heights(depth))
    on_mesh = fresh.worn(depth).mesh.points[fresh.patch.nodes.ravel(), 2]
    assert moved.node_heights(depth) == pytest.approx((-1.0 if upper else 1.0) * on_mesh, abs=1e-15)


def test_a_worn_wire_is_condensed_on_its_moved_nodes(tmp_path: Path) -> None:
    geometry = wire_geometry(0.02, 0.02, 0.04)
    fresh = condensed_wire(geometry, STEEL, tmp_path)
    a, t = fresh.patch.axial_mm, fresh.patch.transverse_mm
    depth = 0.01 * np.outer(np.maximum(1.0 - (a / 0.035) ** 2, 0.0), np.maximum(1.0 - (t / 0.035) ** 2, 0.0))
    worn, smallest = condensed_worn_wire(geometry, STEEL, depth)
    deeper, smaller = condensed_worn_wire(geometry, STEEL, 1.1 * depth)
    assert worn.patch.repositioned_depth_mm == pytest.approx(depth, abs=0.0)
    assert 0.2 < smaller < smallest
    centre = 3 * (fresh.patch.size // 2) + 2
    compliances = [body.compliance[centre, centre] for body in (fresh, worn, deeper)]
    assert len(set(compliances)) == 3
    # A scar a tenth of the wire's thickness changes the local compliance little.
    assert compliances[1] == pytest.approx(compliances[0], rel=0.15)
    assert worn.patch.height(np.zeros((1, 2))) == pytest.approx(-0.01)
