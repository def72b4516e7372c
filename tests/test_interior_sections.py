"""Sections through meshes: what is symmetric is cut into triangles that are, and the field stays what it is."""

import numpy as np
import pytest
import pyvista
from numpy.typing import NDArray

from wirewear.interior.grids import Section, fanned, plane_section, section

FIELD = "von_mises_MPa"


def bricks(flat: bool = False) -> pyvista.UnstructuredGrid:
    """Bricks, or quadrilaterals at y = 0, on an uneven grid that is its own mirror image about x = 0 and y = 0."""
    half = np.array([0.0, 1.0, 2.5, 6.0])
    line = np.concatenate([-half[:0:-1], half])
    grid = pyvista.RectilinearGrid(line, [0.0] if flat else line, half).cast_to_unstructured_grid()
    if flat:
        corners = np.asarray(grid.cells).reshape(-1, 5)[:, 1:]
        # VTK's pixels count their corners row by row.
        grid = pyvista.UnstructuredGrid({pyvista.CellType.QUAD: corners[:, [0, 1, 3, 2]]}, grid.points)
    x, y, z = grid.points.T
    grid.point_data[FIELD] = x**2 + 0.5 * y**2 + z * x**2
    return grid


def corners_of(cut: Section, sign: float = 1.0) -> NDArray[np.float64]:
    """All triangles by their middles and mean values, in order; mirrored with sign −1."""
    of_each = np.column_stack([sign * cut.along, cut.height, cut.values])[cut.triangles].mean(axis=1)
    rounded = np.round(of_each, 9) + 0.0
    return np.asarray(rounded[np.lexsort(rounded.T)])


@pytest.mark.parametrize("axis", [0, 1])
def test_a_section_of_a_symmetric_body_is_symmetric_with_its_triangles(axis: int) -> None:
    cut = section(bricks(), axis, 0.0)
    assert len(cut.triangles) == 4 * 18
    # A section lies a little beside its plane: its values are those there.
    np.testing.assert_allclose(corners_of(cut), corners_of(cut, -1.0), atol=1e-3)


def test_a_line_contacts_body_is_symmetric_with_its_triangles() -> None:
    cut = plane_section(bricks(flat=True))
    assert len(cut.triangles) == 4 * 18
    np.testing.assert_array_equal(corners_of(cut), corners_of(cut, -1.0))


def test_only_what_lies_within_the_nodes_asked_for_is_shown() -> None:
    grid = bricks(flat=True)
    right = np.flatnonzero(grid.points[:, 0] > -1.5)
    cut = plane_section(grid, within=right)
    assert len(cut.triangles) == 4 * 12
    assert cut.along[cut.triangles].min() == -1.0


def test_polygons_of_any_number_of_sides_are_covered_once() -> None:
    points = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0], [1.0, 2.0]])
    values = points @ [3.0, -1.0]
    cut = fanned(points, values, [np.array([0, 1, 2, 3]), np.array([3, 2, 4])])
    x, z = cut.along[cut.triangles], cut.height[cut.triangles]
    areas = 0.5 * ((x[:, 1] - x[:, 0]) * (z[:, 2] - z[:, 0]) - (x[:, 2] - x[:, 0]) * (z[:, 1] - z[:, 0]))
    assert areas.min() > 0.0
    assert areas.sum() == pytest.approx(3.0)
    assert cut.values == pytest.approx(3.0 * cut.along - cut.height)


def test_where_a_plane_passes_by_a_body_there_is_no_section() -> None:
    assert len(section(bricks(), 1, 50.0).triangles) == 0
