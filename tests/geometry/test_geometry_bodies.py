"""Meshes and surfaces of wires, of tubes, and of blocks whose faces are a ball, a barrel, a cylinder or a flat."""

import subprocess
import sys
from math import log, pi
from pathlib import Path

import meshio
import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from geometry import (
    Barrel,
    BlockGeometry,
    BodyMesh,
    Cylinder,
    GeometryError,
    GradedAxis,
    HexMesh,
    Layering,
    QuadMesh,
    WireGeometry,
    build_body,
)
from geometry.sections import wire_section
from solvers.elasticity.condensation import condense
from solvers.elasticity.linear_elasticity import stiffness_matrix
from tests.bodies import STEEL, RADIUS_mm, brick, wire

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
    corner = mesh.points[mesh.surfaces["contact"]]
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
def test_an_exported_mesh_reads_back_with_its_points_and_bricks(meshed: BodyMesh, tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"wire{ending}"
    meshed.mesh.write(path, {"height_mm": meshed.mesh.points[:, 2]} if ending == ".vtu" else None)
    back = meshio.read(path)
    assert back.points == pytest.approx(meshed.mesh.points, abs=1e-12)
    assert np.array_equal(back.cells_dict["hexahedron"], meshed.mesh.cells)
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


AXIS = GradedAxis(0.02, 0.04, 0.03, 0.1)


def tube(bore_mm: float, *, gripped_at_ends: bool = False) -> WireGeometry:
    return WireGeometry(1.0, 2.2, AXIS, AXIS, 0.155, gripped_at_ends=gripped_at_ends, bore_mm=bore_mm)


def ring_compliance(outer_mm: float, inner_mm: float) -> float:
    """How much nearer two opposite unit line loads come on a ring's middle line, mm per N/mm, in plane strain.

    A curved bar's energy by bending, stretching and shear (Timoshenko, Strength of Materials II, 1956, section 16).
    """
    thick, middle = outer_mm - inner_mm, 0.5 * (outer_mm + inner_mm)
    offset = middle - thick / log(outer_mm / inner_mm)
    stretch = thick * STEEL.youngs_modulus_MPa / (1.0 - STEEL.poissons_ratio**2)
    shear = thick * STEEL.youngs_modulus_MPa / (2.0 + 2.0 * STEEL.poissons_ratio) / 1.2
    angle = np.linspace(0.0, pi, 2001)
    s, c, one = np.sin(angle), np.cos(angle), np.ones_like(angle)
    # By half of the load, and by the unknown horizontal force and moment at the crown, which does not turn or move.
    moment, normal, across = (
        np.array([-0.5 * middle * s, middle * (c - 1.0), one]),
        np.array([-0.5 * s, c, 0.0 * one]),
        np.array([0.5 * c, s, 0.0 * one]),
    )
    energy = (
        moment[:, None] * moment / (stretch * offset * middle)
        + (normal[:, None] * normal - (moment[:, None] * normal + normal[:, None] * moment) / middle) / stretch
        + across[:, None] * across / shear
    )
    work = middle * np.trapezoid(energy, angle)
    return float(2.0 * (work[0, 0] - work[0, 1:] @ np.linalg.solve(work[1:, 1:], work[1:, 0])))


@pytest.mark.parametrize("bore_mm", [0.88, 0.94])
def test_a_ring_gives_way_as_a_curved_bar_does_and_better_on_finer_meshes(bore_mm: float) -> None:
    exact = ring_compliance(0.5, 0.5 * bore_mm)
    usual, fine = (_ring(bore_mm, coarse_mm) / exact - 1.0 for coarse_mm in (0.155, 0.05 * (1.0 - bore_mm)))
    assert -0.06 < usual < fine < 0.0
    assert abs(fine) < 0.01


def _ring(bore_mm: float, coarse_mm: float) -> float:
    """How much nearer the crown and the back of a meshed section come, in the middle of the wall."""
    size = min(coarse_mm, (1.0 - bore_mm) / 6.0)
    lines = GradedAxis(size, 0.04, size, 0.1).half_lines()
    points, quads = wire_section(0.5, lines, coarse_mm, Layering(), None, 0.5 * bore_mm)
    stiffness = stiffness_matrix(QuadMesh(points, quads, {}), STEEL).tocsc()
    y, z = points.T
    upper, lower = (np.flatnonzero((y == 0.0) & side) for side in (z > -0.5, z < -0.5))
    held = np.zeros((len(points), 3), dtype=bool)
    held[:, 1] = True
    held[y == 0.0, 0] = True
    held[lower[z[lower].argmin()], 2] = True
    force, moved = np.zeros(held.size), np.zeros(held.size)
    force[3 * upper[z[upper].argmax()] + 2] = -0.5
    free = np.flatnonzero(~held.ravel())
    moved[free] = spsolve(stiffness[free][:, free], force[free])
    middle = 0.25 * (1.0 + bore_mm)
    at = (
        np.interp(level, *(np.sort(z[line]), moved[3 * line[z[line].argsort()] + 2]))
        for line, level in ((upper, middle - 0.5), (lower, -middle - 0.5))
    )
    return float(-np.subtract(*at))


def _compliances(geometry: WireGeometry) -> np.ndarray:
    """Mean displacement by a uniform traction along, across and into the body."""
    meshed = build_body(geometry)
    compliance = condense(meshed.mesh, meshed.patch, STEEL).compliance
    share = meshed.patch.node_areas() / meshed.patch.node_areas().sum()
    return np.array([share @ compliance[k::3, k::3] @ share for k in range(3)])


@pytest.mark.slow
def test_narrow_tubes_are_as_stiff_as_wires_and_wide_ones_softer() -> None:
    wire, narrow, wide = (_compliances(tube(bore_mm)) for bore_mm in (0.0, 0.06, 0.7))
    assert narrow == pytest.approx(wire, rel=0.01)
    assert np.all(wide > 1.3 * wire)


@pytest.fixture(scope="module", params=[0.1, 0.5, 0.94])
def meshed_tube(request: pytest.FixtureRequest) -> BodyMesh:
    return build_body(tube(request.param))


def test_a_tube_is_sound_symmetric_and_held_on_the_outside_of_its_back(meshed_tube: BodyMesh) -> None:
    mesh, geometry = meshed_tube.mesh, meshed_tube.geometry
    assert isinstance(geometry, WireGeometry)
    full = 0.25 * pi * (1.0 - geometry.bore_mm**2) * 2.2
    assert mesh.volume_mm3() == pytest.approx(full, rel=0.015)
    assert meshed_tube.smallest_scaled_jacobian > 0.3
    for axis in (0, 1):
        image = mesh.points.copy()
        image[:, axis] *= -1.0
        assert np.array_equal(image[np.lexsort(image.T)], mesh.points[np.lexsort(mesh.points.T)])
    radius = np.hypot(mesh.points[:, 1], mesh.points[:, 2] + 0.5)
    assert radius.min() == pytest.approx(0.5 * geometry.bore_mm)
    assert radius[mesh.surface_nodes("grip")] == pytest.approx(0.5)
    assert mesh.points[mesh.surface_nodes("grip"), 2].max() < -0.5


def test_a_tube_is_held_all_over_its_ends_and_all_bore_is_refused() -> None:
    mesh = build_body(tube(0.5, gripped_at_ends=True)).mesh
    ends = np.abs(mesh.points[:, 0]) > 1.1 - 1e-12
    assert np.array_equal(mesh.surface_nodes("grip"), np.flatnonzero(ends))
    with pytest.raises(GeometryError, match="bore must be narrower"):
        tube(1.0)


POINTS_mm = np.random.default_rng(1).uniform(-0.55, 0.55, (200, 2))


def block(along_per_mm: float, across_per_mm: float, size_mm: float = 1.0) -> BodyMesh:
    axial, transverse = (
        GradedAxis(part * size_mm, 0.04 * size_mm, 0.03 * size_mm, 0.1 * size_mm) for part in (0.01, 0.012)
    )
    return build_body(
        BlockGeometry(
            along_per_mm, across_per_mm, 0.6 * size_mm, 0.7 * size_mm, size_mm, axial, transverse, 0.2 * size_mm
        )
    )


def test_a_barrel_of_one_radius_is_a_sphere() -> None:
    radius, r = 1.3, np.hypot(*POINTS_mm.T)
    assert Barrel(1.0 / radius, 1.0 / radius).height(POINTS_mm) == pytest.approx(np.sqrt(radius**2 - r**2) - radius)


@pytest.mark.parametrize("along", [False, True])
def test_a_barrel_straight_one_way_is_a_cylinder(along: bool) -> None:
    barrel, cylinder = Barrel(0.8, 0.0) if along else Barrel(0.0, 0.8), Cylinder(1.25, curved_along=along)
    assert barrel.height(POINTS_mm) == pytest.approx(cylinder.height(POINTS_mm))
    assert barrel.slope(POINTS_mm) == pytest.approx(cylinder.slope(POINTS_mm))


def test_slopes_of_a_barrel_follow_its_height_and_flank_patches_are_refused() -> None:
    barrel, step = Barrel(0.7, 1.1), 1e-6
    for axis in (0, 1):
        aside = step * np.eye(2)[axis]
        rise = (barrel.height(POINTS_mm + aside) - barrel.height(POINTS_mm - aside)) / (2.0 * step)
        assert barrel.slope(POINTS_mm)[:, axis] == pytest.approx(rise, abs=1e-7)
    Barrel(0.5, 0.5).require_within(1.0, 1.0)
    with pytest.raises(GeometryError, match="does not fit"):
        Barrel(0.5, 0.5).require_within(1.5, 1.5)


@pytest.mark.parametrize(("along", "across"), [(1.0, 1.0), (0.0, 0.0), (0.0, 1.0), (0.5, 1.0)])
def test_a_block_is_sound_symmetric_and_exactly_its_shape(along: float, across: float) -> None:
    meshed = block(along, across)
    mesh, patch = meshed.mesh, meshed.patch
    points = mesh.points[patch.nodes.ravel()]
    assert points[:, :2] == pytest.approx(patch.grid(), abs=1e-12)
    assert points[:, 2] == pytest.approx(Barrel(along, across).height(points[:, :2]), abs=1e-12)
    assert meshed.smallest_scaled_jacobian > 0.2
    for axis in (0, 1):
        image = mesh.points.copy()
        image[:, axis] *= -1.0
        assert np.array_equal(image[np.lexsort(image.T)], mesh.points[np.lexsort(mesh.points.T)])
    x, y = np.linspace(-0.6, 0.6, 400), np.linspace(-0.7, 0.7, 400)
    grid = np.array(np.meshgrid(x, y, indexing="ij")).reshape(2, -1).T
    sag = Barrel(along, across).height(grid).reshape(400, 400)
    expected = 1.2 * 1.4 + float(np.trapezoid(np.trapezoid(sag, y), x))
    assert mesh.volume_mm3() == pytest.approx(expected, rel=0.02)


def test_a_block_is_held_at_its_back_and_sides_and_nowhere_on_its_face() -> None:
    mesh = block(1.0, 1.0).mesh
    named = np.sort(np.vstack(list(mesh.surfaces.values())), axis=1)
    facets = np.sort(mesh.boundary_facets(), axis=1)
    assert np.array_equal(named[np.lexsort(named.T)], facets[np.lexsort(facets.T)])
    held = mesh.points[mesh.surfaces["grip"]].mean(axis=1)
    aside = (np.abs(held[:, :2]) / [0.6, 0.7]).max(axis=1) > 0.999
    assert np.all(aside | (held[:, 2] < -0.999))
    face = mesh.points[mesh.surfaces["side"]].mean(axis=1)
    assert np.all((np.abs(face[:, :2]) / [0.6, 0.7]).max(axis=1) < 0.999)


@pytest.mark.parametrize("radius_mm", [0.05, 100.0])
def test_balls_of_all_sizes_can_be_meshed(radius_mm: float) -> None:
    assert block(1.0 / radius_mm, 1.0 / radius_mm, radius_mm).smallest_scaled_jacobian > 0.2


def test_a_block_too_narrow_for_its_patch_is_refused() -> None:
    axis = GradedAxis(0.1, 0.2, 0.2, 0.95)
    with pytest.raises(GeometryError, match="give a wider block"):
        BlockGeometry(0.0, 0.0, 1.0, 2.0, 1.0, axis, axis, 0.2)


@pytest.mark.parametrize("thread", [False, True])
def test_a_process_that_has_meshed_outlives_a_broken_pipe(thread: bool) -> None:
    """Servers and notebooks write to whoever may have gone; gmsh alone would have the process end without a word."""
    meshing = "from threading import Thread; t = Thread(target=mesh); t.start(); t.join()" if thread else "mesh()"
    lines = (
        "import os; from geometry.body import gmsh_session",
        "def mesh():",
        "    with gmsh_session(): pass",
        "",
        f"{meshing}; read, write = os.pipe(); os.close(read)",
        "try: os.write(write, b'1')",
        "except BrokenPipeError: print('still here')",
    )
    ended = subprocess.run([sys.executable, "-c", "\n".join(lines)], capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout) == (0, "still here\n")
