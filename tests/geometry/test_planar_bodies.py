"""Bodies of line contacts: meshes between face and back, profiles, patches, worn surfaces and grips."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import geometry

ALONG = geometry.GradedAxis(0.02, 0.1, 0.08, 0.4)
PROFILES: dict[str, geometry.Profile] = {
    "cylinder": geometry.Cylinder(6.0, curved_along=True),
    "flat": geometry.Flat(),
    "rounded": geometry.RoundedFlat(0.3, 2.0),
}


def body(profile: geometry.Profile, half_width_mm: float = 1.5, height_mm: float = 2.0) -> geometry.PlanarMesh:
    return geometry.build_planar(geometry.PlanarGeometry(profile, half_width_mm, height_mm, ALONG, far_mm=0.3))


def line(x: list[float], profile: geometry.Profile | None = None) -> geometry.ContactPatch:
    return geometry.ContactPatch(np.array(x), np.zeros(1), np.arange(len(x))[:, None], profile or geometry.Flat())


@pytest.mark.parametrize("name", PROFILES)
def test_a_body_is_meshed_with_valid_quads_between_its_face_and_its_back(name: str) -> None:
    meshed = body(PROFILES[name])
    mesh, patch = meshed.mesh, meshed.patch
    assert meshed.quality == mesh.scaled_jacobians().min() > 0.3
    contact = mesh.points[patch.nodes[:, 0]]
    assert contact[:, 0] == pytest.approx(patch.axial_mm, abs=1e-14)
    assert contact[:, 1] == pytest.approx(patch.height(patch.grid()), abs=1e-14)
    assert np.array_equal(mesh.surface_nodes("contact"), np.sort(patch.nodes[:, 0]))
    assert mesh.points[mesh.surface_nodes("grip"), 1] == pytest.approx(-2.0)
    assert np.abs(mesh.points[mesh.surface_nodes("sides"), 0]) == pytest.approx(1.5)
    x = np.linspace(-1.5, 1.5, 20_001)
    below = np.trapezoid(PROFILES[name].height(np.column_stack([x, 0.0 * x])), x)
    assert mesh.area_mm2() == pytest.approx(6.0 + below, rel=2e-3)


@pytest.mark.parametrize("name", PROFILES)
def test_the_slope_of_a_profile_is_the_derivative_of_its_height(name: str) -> None:
    profile = PROFILES[name]
    points = np.column_stack([np.linspace(-1.4, 1.4, 41), np.full(41, 0.1)])
    for axis in range(2):
        nudge = 1e-6 * np.eye(2)[axis]
        rise = profile.height(points + nudge) - profile.height(points - nudge)
        assert profile.slope(points)[:, axis] == pytest.approx(rise / 2e-6, abs=1e-6)


@given(st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=9), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_a_line_patch_reproduces_linear_fields_and_their_gradient(x: list[float], value: float, slope: float) -> None:
    patch = line([-1.0, -0.4, 0.0, 0.3, 1.0])
    field = value + slope * patch.axial_mm[:, None]
    points = np.column_stack([x, np.linspace(-5.0, 5.0, len(x))])
    nodes, weights, inside = patch.locate(points)
    assert inside.all()
    assert (field.ravel()[nodes] * weights).sum(axis=1) == pytest.approx(value + slope * points[:, 0], abs=1e-12)
    assert patch.gradient(field) == pytest.approx(np.tile([slope, 0.0], (5, 1)), abs=1e-12)


def test_a_line_patch_stands_for_a_strip_of_unit_thickness() -> None:
    patch = line([-1.0, -0.4, 0.0, 0.3, 1.0])
    assert patch.node_areas().sum() == pytest.approx(2.0)
    assert patch.edge_nodes().tolist() == [True, False, False, False, True]
    assert patch.smallest_element == pytest.approx(0.3)
    _, weights, inside = patch.locate(np.array([[1.1, 0.0], [-1.2, 0.0]]))
    assert not inside.any()
    assert not weights.any()


def test_worn_nodes_stand_in_the_worn_surface_and_the_body_loses_what_is_worn() -> None:
    fresh = body(PROFILES["cylinder"])
    x = fresh.patch.axial_mm
    depth = 0.01 * np.maximum(1.0 - (x / 0.2) ** 2, 0.0)
    worn = fresh.worn(depth)
    nodes = worn.patch.nodes[:, 0]
    np.testing.assert_allclose(worn.mesh.points[nodes, 1], fresh.mesh.points[nodes, 1] - depth, atol=1e-15)
    np.testing.assert_allclose(worn.patch.height(worn.patch.grid()), worn.mesh.points[nodes, 1], atol=1e-12)
    assert fresh.mesh.area_mm2() - worn.mesh.area_mm2() == pytest.approx(np.trapezoid(depth, x), rel=1e-9)
    back = fresh.mesh.surface_nodes("grip")
    np.testing.assert_array_equal(worn.mesh.points[back], fresh.mesh.points[back])
    assert worn.quality >= 0.2


def test_a_grip_holds_the_stated_part_of_the_back_and_gives_way_as_stated() -> None:
    whole = body(PROFILES["flat"])
    assert whole.bedding is None
    narrow = geometry.build_planar(replace(whole.geometry, grip_half_width_mm=0.5, grip_stiffness_N_per_mm3=1e4))
    assert np.abs(narrow.mesh.points[narrow.mesh.surface_nodes("grip"), 0]).max() < 0.7
    assert narrow.bedding is not None
    assert narrow.bedding.sum() == pytest.approx(1e4 * narrow.mesh.surface_lengths("grip").sum())
    assert narrow.mesh.surface_lengths("grip").sum() == pytest.approx(1.0, abs=0.31)
    assert whole.mesh.surface_lengths("grip").sum() == pytest.approx(3.0)
