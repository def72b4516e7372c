"""Blocks whose faces are a ball, a barrel, a cylinder or a flat: surfaces and meshes."""

import numpy as np
import pytest

from geometry import Barrel, BlockGeometry, BodyMesh, Cylinder, GeometryError, GradedAxis, build_body

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


def test_slopes_of_a_barrel_are_those_of_its_height() -> None:
    barrel, step = Barrel(0.7, 1.1), 1e-6
    for axis in (0, 1):
        aside = step * np.eye(2)[axis]
        rise = (barrel.height(POINTS_mm + aside) - barrel.height(POINTS_mm - aside)) / (2.0 * step)
        assert barrel.slope(POINTS_mm)[:, axis] == pytest.approx(rise, abs=1e-7)


def test_a_barrel_in_another_unit_is_the_same_surface() -> None:
    barrel = Barrel(0.7, 1.1)
    assert barrel.scaled(1e-3).height(1e-3 * POINTS_mm) == pytest.approx(1e-3 * barrel.height(POINTS_mm))


def test_a_patch_that_reaches_the_flank_is_refused() -> None:
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
