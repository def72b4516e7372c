"""Fields inside the wires of a run: positions, meshes, files for ParaView, pictures."""

from pathlib import Path

import numpy as np
import pytest
import pyvista
from click.testing import CliRunner

from geometry.arrays import Array
from tests.interior_runs import CYCLE, FRICTION, LOAD_N, DEPTH_um, run_with_forces
from wirewear.faces import cli
from wirewear.faces.looking import Run, read_result
from wirewear.interior import body_grid, body_states, integration_point_cloud
from wirewear.interior.bodies import Section, fanned, section
from wirewear.results import write_result

FIELD = "von_mises_MPa"

WIRES = ("moving", "fixed")


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


def corners_of(cut: Section, sign: float = 1.0) -> Array:
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


def test_polygons_of_any_number_of_sides_are_covered_once() -> None:
    points = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0], [1.0, 2.0]])
    values = points @ [3.0, -1.0]
    cut = fanned(points, values, [np.array([0, 1, 2, 3]), np.array([3, 2, 4])])
    x, z = cut.along[cut.triangles], cut.height[cut.triangles]
    areas = 0.5 * ((x[:, 1] - x[:, 0]) * (z[:, 2] - z[:, 0]) - (x[:, 2] - x[:, 0]) * (z[:, 1] - z[:, 0]))
    assert areas.min() > 0.0
    assert areas.sum() == pytest.approx(3.0)
    assert cut.values == pytest.approx(3.0 * cut.along - cut.height)


@pytest.fixture(scope="module")
def run() -> Run:
    return Run.of(run_with_forces())


@pytest.fixture(scope="module")
def stored(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("run") / "result.h5"
    write_result(path, run)
    return path


def test_contact_forces_survive_the_file(run: Run, stored: Path) -> None:
    again = read_result(stored)
    for before, after in zip(run.contact_forces, again.contact_forces, strict=True):
        assert (before.geometry, before.material, before.body) == (after.geometry, after.material, after.body)
        np.testing.assert_array_equal(before.force_N, after.force_N)
        np.testing.assert_array_equal(before.nodes, after.nodes)


@pytest.mark.seconds
@pytest.mark.parametrize("wire", WIRES)
def test_the_grip_holds_what_the_contact_gives(run: Run, wire: str) -> None:
    (state,) = body_states(run, wire, CYCLE, ["mid-forward"])
    total = state.reaction_N.sum(axis=0) @ state.to_world.T
    sign = 1.0 if wire == "moving" else -1.0
    # The moving wire goes forward, so friction drives the fixed one along +x.
    expected = sign * np.array([FRICTION * LOAD_N, 0.0, LOAD_N])
    np.testing.assert_allclose(total, expected, rtol=1e-8, atol=1e-8 * LOAD_N)
    assert state.forces.tangential_force_N[state.position] == pytest.approx(FRICTION * LOAD_N)


@pytest.mark.seconds
def test_nodes_stand_in_the_worn_surface_in_sound_elements(run: Run) -> None:
    worn, fresh = (body_states(run, "fixed", CYCLE, [0], worn=worn)[0] for worn in (True, False))
    patch = worn.body.wire.patch
    middle = patch.nodes[patch.shape[0] // 2, patch.shape[1] // 2]
    mesh, before = worn.body.wire.mesh, fresh.body.wire.mesh
    assert mesh.points[middle, 2] - before.points[middle, 2] == pytest.approx(-1e-3 * DEPTH_um)
    assert mesh.scaled_jacobians().min() >= 0.2
    # Beneath a shallow bowl the stress is nearly that of the fresh wire under the same forces.
    assert np.abs(worn.stress_at_points).max() == pytest.approx(np.abs(fresh.stress_at_points).max(), rel=0.2)


def test_stroke_and_its_mirror_image_give_mirrored_fields(run: Run) -> None:
    there, back = (run.body("moving", CYCLE, at) for at in ("mid-forward", "mid-back"))
    order, mirrored = (np.lexsort(np.round(p, 6).T) for p in (there.points, back.points * [-1.0, 1.0, 1.0]))
    np.testing.assert_allclose(
        there.point_data["von_mises_MPa"][order], back.point_data["von_mises_MPa"][mirrored], rtol=1e-6, atol=1e-4
    )


def test_integration_points_lie_in_the_body_with_what_the_elements_compute(run: Run) -> None:
    (state,) = body_states(run, "fixed", CYCLE, [0])
    cloud = integration_point_cloud(state)
    assert cloud.n_points == 8 * len(state.body.wire.mesh.cells)
    assert cloud.point_data["stress_MPa"].shape == (cloud.n_points, 6)
    grid = body_grid(state)
    mean = cloud.point_data["von_mises_MPa"].reshape(-1, 8).mean(axis=1)
    np.testing.assert_allclose(mean, grid.cell_data["von_mises_MPa"], rtol=1e-9)


@pytest.mark.seconds
def test_a_cycle_that_stands_for_another_one_is_said(tmp_path: Path) -> None:
    write_result(tmp_path / "result.h5", run_with_forces())
    asked = ["fields", str(tmp_path), "--cycle", "77", "--no-pictures", "--output", str(tmp_path / "fields")]
    outcome = CliRunner().invoke(cli, asked, catch_exceptions=False)
    assert outcome.exit_code == 0, outcome.output
    assert "cycle 77 is not recorded, 100 is taken; recorded are 100." in outcome.stderr
