"""The hexahedral mesh of a wire."""

from math import pi
from pathlib import Path

import meshio
import numpy as np
import pytest

from geometry import BodyMesh, GeometryError, GradedAxis, HexMesh, WireGeometry, build_body
from tests.bodies import RADIUS_mm, brick, wire

FINE_mm = 0.010


@pytest.fixture(scope="module")
def meshed() -> BodyMesh:
    return wire(FINE_mm)


def ordered(points: np.ndarray) -> np.ndarray:
    return points[np.lexsort(points.T)]


def test_a_wire_fills_its_cylinder_with_undistorted_bricks(meshed: BodyMesh) -> None:
    mesh = meshed.mesh
    assert mesh.cells.shape[1] == 8
    assert np.array_equal(np.unique(mesh.cells), np.arange(len(mesh.points)))
    # Chords of 0.12 mm at the back of the wire cut off 2.7 % of its section.
    assert 0.97 < mesh.volume_mm3() / (pi * RADIUS_mm**2 * 1.0) < 1.0
    assert meshed.smallest_scaled_jacobian == pytest.approx(mesh.scaled_jacobians().min())
    assert meshed.smallest_scaled_jacobian > 0.2
    assert len(np.unique(np.round(mesh.points / 1e-7), axis=0)) == len(mesh.points)


@pytest.mark.parametrize("axis", [0, 1])
def test_a_wire_is_its_own_mirror_image_to_the_bit(meshed: BodyMesh, axis: int) -> None:
    image = meshed.mesh.points.copy()
    image[:, axis] *= -1.0
    assert np.array_equal(ordered(image), ordered(meshed.mesh.points))


def test_the_named_surfaces_cover_the_boundary_exactly_once(meshed: BodyMesh) -> None:
    mesh = meshed.mesh
    assert set(mesh.surfaces) == {"contact", "grip", "side", "ends"}
    named = np.sort(np.vstack(list(mesh.surfaces.values())), axis=1)
    assert np.array_equal(ordered(named), ordered(np.sort(mesh.boundary_facets(), axis=1)))


def test_the_named_surfaces_lie_where_their_names_say(meshed: BodyMesh) -> None:
    mesh, half_length = meshed.mesh, 0.5
    assert np.abs(mesh.points[mesh.surface_nodes("ends"), 0]) == pytest.approx(half_length)
    grip = mesh.points[mesh.surface_nodes("grip")]
    assert np.hypot(grip[:, 1], grip[:, 2] + RADIUS_mm) == pytest.approx(RADIUS_mm)
    assert np.all(grip[:, 2] < -RADIUS_mm)
    assert np.array_equal(mesh.surface_nodes("contact"), np.unique(meshed.patch.nodes))
    contact = mesh.surfaces["contact"]
    corner = mesh.points[contact]
    outward = np.cross(corner[:, 1] - corner[:, 0], corner[:, 3] - corner[:, 0])
    assert np.all(outward[:, 2] > 0.0)


def test_the_patch_describes_the_nodes_of_the_mesh(meshed: BodyMesh) -> None:
    patch = meshed.patch
    points = meshed.mesh.points[patch.nodes.ravel()]
    plane = patch.grid()
    assert points[:, :2] == pytest.approx(plane, abs=1e-12)
    assert points[:, 2] == pytest.approx(patch.height(plane), abs=1e-12)
    assert patch.node_areas().sum() == pytest.approx(4.0 * 0.04 * 0.04)
    nudge = 1e-6
    rise = patch.height(plane + [0.0, nudge]) - patch.height(plane - [0.0, nudge])
    assert patch.profile.slope(plane)[:, 1] == pytest.approx(rise / (2.0 * nudge), abs=1e-7)
    assert not patch.profile.slope(plane)[:, 0].any()


def test_a_distorted_mesh_is_refused_with_the_place_of_its_worst_element() -> None:
    mesh = brick((3, 3, 3), (0.3, 0.3, 0.3))
    points = mesh.points.copy()
    inner = int(np.argmin(np.linalg.norm(points - [0.05, 0.05, -0.1], axis=1)))
    points[inner] = [0.145, 0.145, -0.02]
    distorted = HexMesh(points, mesh.cells, mesh.surfaces)
    with pytest.raises(GeometryError, match=r"at \(0\.\d+, 0\.\d+, -0\.0\d+\) mm has a scaled Jacobian of -?[01]\.\d+"):
        distorted.require_quality(0.2)
    assert mesh.require_quality(0.2) == pytest.approx(1.0)


def test_a_sheared_brick_has_the_known_scaled_jacobian() -> None:
    mesh = brick((1, 1, 1), (1.0, 1.0, 1.0))
    sheared = mesh.points + np.outer(mesh.points[:, 2], [1.0, 0.0, 0.0])
    assert HexMesh(sheared, mesh.cells, {}).scaled_jacobians() == pytest.approx([np.sqrt(0.5)])


def test_a_mirrored_mesh_keeps_its_orientation_and_joins_its_surfaces() -> None:
    block = brick((2, 2, 2), (1.0, 1.0, 1.0), distortion=0.2)
    half = HexMesh(block.points + [0.5, 0.0, 0.0], block.cells, block.surfaces)
    whole = half.with_mirror_image(axis=0)
    assert whole.volume_mm3() == pytest.approx(2.0 * half.volume_mm3())
    assert whole.scaled_jacobians().min() == pytest.approx(half.scaled_jacobians().min())
    assert len(whole.points) == 2 * len(half.points) - 9
    assert len(whole.surfaces["top"]) == 2 * len(half.surfaces["top"])
    corner = whole.points[whole.surfaces["top"]]
    assert np.all(np.cross(corner[:, 1] - corner[:, 0], corner[:, 3] - corner[:, 0])[:, 2] > 0.0)


@pytest.mark.parametrize("ending", [".vtu", ".msh", ".inp"])
def test_an_exported_mesh_reads_back_with_the_same_points_and_bricks(
    meshed: BodyMesh, tmp_path: Path, ending: str
) -> None:
    path = tmp_path / f"wire{ending}"
    meshed.mesh.write(path, {"height_mm": meshed.mesh.points[:, 2]} if ending == ".vtu" else None)
    back = meshio.read(path)
    assert back.points == pytest.approx(meshed.mesh.points, abs=1e-12)
    assert np.array_equal(back.cells_dict["hexahedron"], meshed.mesh.cells)
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("diameter_mm", "length_mm", "fine_mm", "half_mm", "coarse_mm"),
    [
        (0.45, 1.0, 0.004, 0.13, 0.07),
        (12.0, 30.0, 0.2, 1.0, 2.0),
        (0.1, 0.5, 0.01, 0.042, 0.05),
        (1.0, 2.0, 0.05, 0.2, 0.5),
    ],
)
def test_wires_of_very_different_sizes_can_be_meshed(
    diameter_mm: float, length_mm: float, fine_mm: float, half_mm: float, coarse_mm: float
) -> None:
    axis = GradedAxis(fine_mm, 0.3 * half_mm, 3.0 * fine_mm, half_mm)
    meshed = build_body(WireGeometry(diameter_mm, length_mm, axis, axis, coarse_mm))
    # Coarse chords at the back of the wire cut off up to a tenth of the section.
    assert meshed.mesh.volume_mm3() == pytest.approx(0.25 * pi * diameter_mm**2 * length_mm, rel=0.12)
    assert meshed.smallest_scaled_jacobian > 0.2
