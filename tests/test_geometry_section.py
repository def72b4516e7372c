"""The quadrilaterals that half a wire's cross-section is divided into."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geometry import GradedAxis, Layering
from geometry.wire_section import wire_section

Array = NDArray[np.float64]


@st.composite
def sections(draw: st.DrawFn) -> tuple[float, GradedAxis, float, Layering]:
    """Radius, transverse grading, coarse size and layers: patches up to 0.42 diameters, elements over two decades."""
    radius = draw(st.floats(0.05, 20.0))
    half = radius * draw(st.floats(0.03, 0.84))
    fine = half * 10.0 ** draw(st.floats(-2.0, -0.3))
    axis = GradedAxis(
        fine_mm=fine,
        fine_half_extent_mm=half * draw(st.floats(0.02, 1.0)),
        outer_mm=min(fine * draw(st.floats(1.0, 5.0)), half),
        half_extent_mm=half,
        growth=draw(st.floats(1.05, 1.5)),
    )
    layering = Layering(draw(st.integers(3, 10)), draw(st.floats(1.05, 1.35)), draw(st.floats(0.5, 1.0)))
    return radius, axis, radius * 10.0 ** draw(st.floats(-1.0, 0.0)), layering


def corner_sines(points: Array, quads: NDArray[np.int64]) -> Array:
    """Sine of the angle at each corner, (m, 4): positive at all four for a convex counter-clockwise quad."""
    corners = points[quads]
    ahead = np.roll(corners, -1, axis=1) - corners
    behind = np.roll(corners, 1, axis=1) - corners
    cross = ahead[..., 0] * behind[..., 1] - ahead[..., 1] * behind[..., 0]
    return np.asarray(cross / np.linalg.norm(ahead, axis=2) / np.linalg.norm(behind, axis=2))


def quad_areas(points: Array, quads: NDArray[np.int64]) -> Array:
    y, z = points[quads].transpose(2, 0, 1)
    return np.asarray(0.5 * (y * np.roll(z, -1, axis=1) - np.roll(y, -1, axis=1) * z).sum(axis=1))


@settings(max_examples=60)
@given(sections())
def test_quads_are_convex_counter_clockwise_and_fill_the_half_disc(
    parameters: tuple[float, GradedAxis, float, Layering],
) -> None:
    radius, axis, coarse, layering = parameters
    points, quads = wire_section(radius, axis.half_lines(), coarse, layering)
    assert corner_sines(points, quads).min() > 0.2
    # The area is that of the polygon of surface nodes: every facet cuts a circular segment off.
    on_rim = np.abs(np.hypot(points[:, 0], points[:, 1] + radius) - radius) < 1e-9 * radius
    angles = np.sort(np.arctan2(points[on_rim, 0], points[on_rim, 1] + radius))
    assert quad_areas(points, quads).sum() == pytest.approx(0.5 * radius**2 * np.sin(np.diff(angles)).sum(), rel=1e-9)
    assert angles[[0, -1]] == pytest.approx([0.0, np.pi])


@settings(max_examples=60)
@given(sections())
def test_every_patch_line_is_a_node_on_the_surface_and_no_node_is_doubled(
    parameters: tuple[float, GradedAxis, float, Layering],
) -> None:
    radius, axis, coarse, layering = parameters
    lines = axis.half_lines()
    points, quads = wire_section(radius, lines, coarse, layering)
    on_top = points[
        (points[:, 1] > -radius) & (np.abs(np.hypot(points[:, 0], points[:, 1] + radius) / radius - 1) < 1e-9)
    ]
    distance = np.abs(on_top[:, 0][:, None] - lines[None, :]).min(axis=0)
    assert distance.max() < 1e-9 * radius
    assert np.array_equal(np.unique(quads), np.arange(len(points)))
    assert len(np.unique(np.round(points / (1e-7 * radius)), axis=0)) == len(points)


@pytest.mark.parametrize("coarse_share", [0.4, 0.2, 0.1])
def test_the_area_tends_to_the_half_disc_as_the_mesh_is_refined(coarse_share: float) -> None:
    axis = GradedAxis(0.1 * coarse_share, 0.1 * coarse_share, coarse_share, 0.2)
    points, quads = wire_section(1.0, axis.half_lines(), coarse_share, Layering())
    missing = 1.0 - quad_areas(points, quads).sum() / (0.5 * np.pi)
    # Chords of length h cut off at most h^2 / 6 of the disc.
    assert 0.0 < missing < (1.3 * coarse_share) ** 2 / 6.0


def test_the_symmetry_plane_is_met_exactly() -> None:
    points, _ = wire_section(0.225, GradedAxis(0.005, 0.02, 0.01, 0.08).half_lines(), 0.08, Layering())
    assert points[:, 0].min() == 0.0
    assert np.count_nonzero(points[:, 0] == 0.0) == np.count_nonzero(points[:, 0] < 1e-6)
