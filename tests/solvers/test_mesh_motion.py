"""Surface nodes moved into the worn surface, and the body condensed again."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from geometry import BodyMesh, ContactPatch, Cylinder, EdgeGradedAxis, GeometryError, GradedAxis, Layering
from geometry.arrays import Array
from geometry.mesh import lowered
from geometry.sections import wire_section
from solvers import place, transferred
from tests import bodies
from tests.bodies import STEEL, brick, wire, wire_geometry
from wirewear.simulation.problem import condensed_body, condensed_worn_body

FINE_mm = 0.010


@st.composite
def sections(draw: st.DrawFn) -> tuple[float, GradedAxis, float, Layering]:
    """Radius, transverse grading, coarse size and layers: patches up to 0.42 diameters, elements over two decades."""
    radius = draw(st.floats(0.05, 20.0))
    half = radius * draw(st.floats(0.03, 0.84))
    fine = half * 10.0 ** draw(st.floats(-2.0, -0.3))
    axis = GradedAxis(
        fine_mm=fine, fine_half_extent_mm=half * draw(st.floats(0.02, 1.0)),
        outer_mm=min(fine * draw(st.floats(1.0, 5.0)), half), half_extent_mm=half, growth=draw(st.floats(1.05, 1.5)),
    )  # fmt: skip
    layering = Layering(draw(st.integers(3, 10)), draw(st.floats(1.05, 1.35)), draw(st.floats(0.5, 1.0)))
    return radius, axis, radius * 10.0 ** draw(st.floats(-1.0, 0.0)), layering


@settings(max_examples=60)
@given(sections())
def test_quads_are_convex_counter_clockwise_and_fill_the_half_disc_below_the_patch_lines(
    parameters: tuple[float, GradedAxis, float, Layering],
) -> None:
    radius, axis, coarse, layering = parameters
    lines = axis.half_lines()
    points, quads = wire_section(radius, lines, coarse, layering)
    corners = points[quads]
    ahead, behind = (np.roll(corners, step, axis=1) - corners for step in (-1, 1))
    cross = ahead[..., 0] * behind[..., 1] - ahead[..., 1] * behind[..., 0]
    # The sine at each corner.
    assert (cross / np.linalg.norm(ahead, axis=2) / np.linalg.norm(behind, axis=2)).min() > 0.2
    # The area is that of the polygon of surface nodes: every facet cuts a circular segment off.
    on_rim = np.abs(np.hypot(points[:, 0], points[:, 1] + radius) - radius) < 1e-9 * radius
    angles = np.sort(np.arctan2(points[on_rim, 0], points[on_rim, 1] + radius))
    y, z = points[quads].transpose(2, 0, 1)
    areas = 0.5 * (y * np.roll(z, -1, axis=1) - np.roll(y, -1, axis=1) * z).sum(axis=1)
    assert areas.sum() == pytest.approx(0.5 * radius**2 * np.sin(np.diff(angles)).sum(), rel=1e-9)
    assert angles[[0, -1]] == pytest.approx([0.0, np.pi])
    # Every patch line is a node on the surface, and no node is doubled.
    on_top = points[
        (points[:, 1] > -radius) & (np.abs(np.hypot(points[:, 0], points[:, 1] + radius) / radius - 1) < 1e-9)
    ]
    assert np.abs(on_top[:, 0][:, None] - lines[None, :]).min(axis=0).max() < 1e-9 * radius
    assert np.array_equal(np.unique(quads), np.arange(len(points)))
    assert len(np.unique(np.round(points / (1e-7 * radius)), axis=0)) == len(points)


@st.composite
def axes(draw: st.DrawFn) -> GradedAxis:
    half = draw(st.floats(0.01, 1.0))
    fine = half * draw(st.floats(0.01, 1.0))
    return GradedAxis(
        fine_mm=fine, fine_half_extent_mm=half * draw(st.floats(0.01, 1.0)),
        outer_mm=fine * draw(st.floats(1.0, 10.0)), half_extent_mm=half, growth=draw(st.floats(1.0, 2.0)),
    )  # fmt: skip


@given(axes())
def test_lines_are_symmetric_to_the_bit_end_exactly_on_the_edges_and_grow_as_asked(axis: GradedAxis) -> None:
    lines = axis.lines()
    assert np.array_equal(lines, -lines[::-1])
    assert lines[-1] == axis.half_extent_mm
    assert lines[len(lines) // 2] == 0.0
    assert np.all(np.diff(lines) > 0.0)
    # Elements are uniform in the middle and grow outwards within their limit.
    sizes = np.diff(axis.half_lines())
    stretch = sizes[0] / axis.fine_mm
    assert abs(axis.half_extent_mm - axis.half_extent_mm / stretch) < 0.71 * sizes.max() / stretch
    fine_count = int(np.ceil(axis.fine_half_extent_mm / axis.fine_mm - 1e-6))
    assert sizes[:fine_count] == pytest.approx(sizes[0])
    ratios = sizes[1:] / sizes[:-1]
    assert np.all(ratios > 1.0 - 1e-9)
    assert np.all(ratios < axis.growth + 1e-9)
    assert sizes.max() <= axis.outer_mm * stretch * (1.0 + 1e-9)


@given(st.floats(1e-3, 0.02), st.floats(1.0, 10.0), st.floats(0.1, 3.0), st.floats(0.05, 0.5))
def test_lines_fine_at_the_ends_keep_their_sizes_there(fine: float, coarser: float, middle: float, edge: float) -> None:
    lines = EdgeGradedAxis(fine, coarser * fine, middle, middle + edge).half_lines()
    sizes = np.diff(lines)
    assert lines[0] == 0.0
    assert lines[-1] == middle + edge
    assert (sizes > 0.0).all()
    at_edge = lines[:-1] >= middle * (1.0 - 1e-12)
    assert sizes[at_edge].max() <= fine * (1.0 + 1e-9)
    # All layers are stretched together to fill the middle, by less than one of them.
    assert sizes[~at_edge].max() <= 1.5 * coarser * fine


@pytest.fixture(scope="module")
def fresh() -> BodyMesh:
    return wire(FINE_mm)


def scar(of: BodyMesh, deepest_mm: float) -> Array:
    a, t = of.patch.axial_mm / 0.035, of.patch.transverse_mm / 0.035
    return np.asarray(deepest_mm * np.outer(np.maximum(1.0 - a**2, 0.0), np.maximum(1.0 - t**2, 0.0)))


def test_the_body_shrinks_by_the_worn_volume_and_nothing_but_the_patch_of_its_boundary_moves(fresh: BodyMesh) -> None:
    depth = scar(fresh, 0.008)
    worn = fresh.worn(depth)
    lost = fresh.mesh.volume_mm3() - worn.mesh.volume_mm3()
    assert lost == pytest.approx(float(depth.ravel() @ fresh.patch.node_areas()), rel=1e-9)
    worn = fresh.worn(scar(fresh, 0.008))
    points = worn.mesh.points[worn.patch.nodes.ravel()]
    assert points[:, :2] == pytest.approx(worn.patch.grid(), abs=1e-12)
    assert points[:, 2] == pytest.approx(worn.patch.height(worn.patch.grid()), abs=1e-12)
    other = np.setdiff1d(np.unique(fresh.mesh.boundary_facets()), fresh.patch.nodes)
    assert np.array_equal(worn.mesh.points[other], fresh.mesh.points[other])


@pytest.mark.parametrize("deepest_mm", [0.001, 0.008, 0.015])
def test_every_element_stays_sound_and_the_worst_is_reported(fresh: BodyMesh, deepest_mm: float) -> None:
    worn = fresh.worn(scar(fresh, deepest_mm))
    assert worn.smallest_scaled_jacobian == pytest.approx(worn.mesh.scaled_jacobians().min())
    assert worn.smallest_scaled_jacobian > 0.2


def test_a_motion_that_folds_elements_is_refused_with_their_place(fresh: BodyMesh) -> None:
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


@pytest.mark.seconds
@pytest.mark.parametrize("upper", [True, False])
def test_a_placed_body_sees_one_surface_whether_nodes_were_moved_into_it_or_not(fresh: BodyMesh, upper: bool) -> None:
    depth = scar(fresh, 0.008)
    body = place(bodies.condensed_wire(FINE_mm), upper=upper, axis_angle_rad=0.7)
    moved = replace(body, patch=fresh.worn(depth).patch)
    assert np.array_equal(moved.worn(depth).heights, body.worn(depth).heights)
    on_mesh = fresh.worn(depth).mesh.points[fresh.patch.nodes.ravel(), 2]
    assert moved.worn(depth).heights == pytest.approx((-1.0 if upper else 1.0) * on_mesh, abs=1e-15)


@pytest.mark.seconds
def test_a_worn_wire_is_condensed_on_its_moved_nodes(tmp_path: Path) -> None:
    geometry = wire_geometry(0.02, 0.02, 0.04)
    fresh = condensed_body(geometry, STEEL, tmp_path)
    a, t = fresh.patch.axial_mm, fresh.patch.transverse_mm
    depth = 0.01 * np.outer(np.maximum(1.0 - (a / 0.035) ** 2, 0.0), np.maximum(1.0 - (t / 0.035) ** 2, 0.0))
    worn, smallest = condensed_worn_body(geometry, STEEL, depth)
    deeper, smaller = condensed_worn_body(geometry, STEEL, 1.1 * depth)
    assert worn.patch.repositioned_depth_mm == pytest.approx(depth, abs=0.0)
    assert 0.2 < smaller < smallest
    centre = 3 * (fresh.patch.size // 2) + 2
    compliances = [body.compliance[centre, centre] for body in (fresh, worn, deeper)]
    assert len(set(compliances)) == 3
    # A scar a tenth of the wire's thickness changes the local compliance little.
    assert compliances[1] == pytest.approx(compliances[0], rel=0.15)
    assert worn.patch.height(np.zeros((1, 2))) == pytest.approx(-0.01)


RADIUS_mm = 0.225


def patch(axial: Array, transverse: Array) -> ContactPatch:
    nodes = np.arange(len(axial) * len(transverse)).reshape(len(axial), len(transverse))
    return ContactPatch(axial, transverse, nodes, Cylinder(RADIUS_mm))


def even(half_mm: float, count: int) -> ContactPatch:
    lines = np.linspace(-half_mm, half_mm, count)
    return patch(lines, lines)


def integral(field: Array, on: ContactPatch) -> float:
    return float(field.ravel() @ on.node_areas())


@st.composite
def grids(draw: st.DrawFn, half_mm: float) -> Array:
    """Lines over at least the given half-extent, their spacings up to twenty times different."""
    spacing = np.array(draw(st.lists(st.floats(0.05, 1.0), min_size=2, max_size=12)))
    lines = np.append(0.0, np.cumsum(spacing)) / spacing.sum() - draw(st.floats(0.4, 0.6))
    return np.asarray(lines * half_mm * 2.0 / 0.8 * draw(st.floats(1.0, 1.3)))


@st.composite
def worn(draw: st.DrawFn) -> tuple[ContactPatch, Array]:
    """A patch and any non-negative depth on it."""
    old = patch(draw(grids(0.02)), draw(grids(0.02)))
    return old, draw(arrays(float, old.shape, elements=st.sampled_from([0.0, 0.0, 1e-9, 1e-3, 0.04])))


@pytest.mark.seconds
@settings(max_examples=150)
@given(worn(), grids(0.06), grids(0.06))
def test_any_depth_keeps_its_volume_and_never_becomes_negative(
    given_wear: tuple[ContactPatch, Array], axial: Array, transverse: Array
) -> None:
    old, depth = given_wear
    new = patch(axial, transverse)
    moved = transferred(depth, old, new)
    assert moved.shape == new.shape
    assert moved.min() >= 0.0
    assert integral(moved, new) == pytest.approx(integral(depth, old), rel=1e-12, abs=1e-25)


@pytest.mark.seconds
@given(worn(), st.integers(1, 4))
def test_a_grid_that_holds_the_old_lines_shows_its_surface(given_wear: tuple[ContactPatch, Array], pieces: int) -> None:
    old, depth = given_wear

    def divided(lines: Array) -> Array:
        count = len(lines) - 1
        return np.interp(np.arange(count * pieces + 1) / pieces, np.arange(count + 1), lines)

    moved = transferred(depth, old, patch(divided(old.axial_mm), divided(old.transverse_mm)))
    assert moved[::pieces, ::pieces] == pytest.approx(depth, rel=1e-9, abs=1e-12)


def scar_of_transfer(on: ContactPatch) -> Array:
    a, t = (lines / 0.05 for lines in (on.axial_mm, on.transverse_mm))
    return np.asarray(0.01 * np.outer(np.maximum(1.0 - a**2, 0.0) ** 3, np.maximum(1.0 - t**2, 0.0) ** 3))


def graded(half_mm: float, count: int) -> ContactPatch:
    s = np.linspace(-1.0, 1.0, count)
    lines = half_mm * (0.5 * s + 0.5 * s**3)
    return patch(lines, lines)


def test_a_smooth_scar_arrives_with_second_order_accuracy_on_a_grid_of_other_grading() -> None:
    errors = []
    for count in (33, 65, 129):
        old, new = even(0.06, count), graded(0.07, count + 3)
        squared = (transferred(scar_of_transfer(old), old, new) - scar_of_transfer(new)) ** 2
        errors.append(float(np.sqrt(integral(squared, new) / integral(scar_of_transfer(new) ** 2, new))))
    assert errors[0] < 0.01
    assert errors[0] / errors[1] > 3.4
    assert errors[1] / errors[2] > 3.4


def test_a_planar_scar_keeps_its_area() -> None:
    old, new = (patch(np.linspace(-0.06, 0.06, count), np.zeros(1)) for count in (25, 32))
    depth = scar_of_transfer(even(0.06, 25))[:, 12:13]
    assert integral(transferred(depth, old, new), new) == pytest.approx(integral(depth, old), rel=1e-12)
