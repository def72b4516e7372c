"""Fields inside the wires of a run: positions, meshes, files for ParaView, pictures."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import pyvista
from click.testing import CliRunner
from numpy.typing import NDArray
from PIL import Image

from tests.interior_runs import CYCLE, FRICTION, LOAD_N, POSITIONS, DEPTH_um, run_with_forces
from tests.picture_pixels import PANELS, shows
from wirewear.base.errors import ResultError
from wirewear.faces import cli
from wirewear.faces.looking import Run, read_result
from wirewear.interior import body_grid, body_states, integration_point_cloud
from wirewear.interior.grids import Section, fanned, plane_section, section
from wirewear.interior.pictures import STRESS_COLOURS
from wirewear.pictures.colours import INK, PRESSURE_COLOURS
from wirewear.results import POSITIONS as NAMES
from wirewear.results import ContactForces, write_result

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


@pytest.fixture(scope="module")
def run() -> Run:
    return Run.of(run_with_forces())


@pytest.fixture(scope="module")
def stored(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("run") / "result.h5"
    write_result(path, run)
    return path


def test_the_named_positions_are_where_they_say(run: Run) -> None:
    forces = run.forces(CYCLE, "fixed")
    phases = {name: forces.phase[k] for name, k in forces.named().items()}
    assert phases == {
        "mid-forward": 0.75,
        "end-forward": 1.0,
        "after-end-forward": 0.125,
        "mid-back": 0.25,
        "end-back": 0.5,
        "after-end-back": 0.625,
    }
    assert set(phases) == set(NAMES)
    assert [forces.position(at) for at in (3, "3")] == [3, 3]
    with pytest.raises(ResultError, match="choose one of mid-forward"):
        forces.position("somewhere")
    with pytest.raises(ResultError, match="positions 0 to 7"):
        forces.position(8)


def test_contact_forces_survive_the_file(run: Run, stored: Path) -> None:
    again = read_result(stored)
    for before, after in zip(run.contact_forces, again.contact_forces, strict=True):
        assert (before.geometry, before.material, before.body) == (after.geometry, after.material, after.body)
        np.testing.assert_array_equal(before.force_N, after.force_N)
        np.testing.assert_array_equal(before.nodes, after.nodes)


def test_forces_that_do_not_fit_their_nodes_are_refused(run: Run) -> None:
    good = run.contact_forces[0]
    with pytest.raises(ResultError, match="shape"):
        replace(good, nodes=good.nodes[1:])
    with pytest.raises(ResultError, match="wire must be"):
        replace(good, body="other")


def test_a_run_without_recorded_forces_says_so(run: Run) -> None:
    with pytest.raises(ResultError, match="no contact forces of the fixed wire"):
        body_states(replace(run, contact_forces=()), "fixed", CYCLE)


@pytest.mark.parametrize("wire", WIRES)
def test_the_grip_holds_what_the_contact_gives(run: Run, wire: str) -> None:
    (state,) = body_states(run, wire, CYCLE, ["mid-forward"])
    total = state.reaction_N.sum(axis=0) @ state.to_world.T
    sign = 1.0 if wire == "moving" else -1.0
    # The moving wire goes forward, so friction drives the fixed one along +x.
    expected = sign * np.array([FRICTION * LOAD_N, 0.0, LOAD_N])
    np.testing.assert_allclose(total, expected, rtol=1e-8, atol=1e-8 * LOAD_N)
    assert state.forces.tangential_force_N[state.position] == pytest.approx(FRICTION * LOAD_N)


def test_nodes_stand_in_the_worn_surface_in_sound_elements(run: Run) -> None:
    worn, fresh = (body_states(run, "fixed", CYCLE, [0], worn=worn)[0] for worn in (True, False))
    patch = worn.body.wire.patch
    middle = patch.nodes[patch.shape[0] // 2, patch.shape[1] // 2]
    mesh, before = worn.body.wire.mesh, fresh.body.wire.mesh
    assert mesh.points[middle, 2] - before.points[middle, 2] == pytest.approx(-1e-3 * DEPTH_um)
    assert mesh.scaled_jacobians().min() >= 0.2
    # Beneath a shallow bowl the stress is nearly that of the fresh wire under the same forces.
    assert np.abs(worn.stress_at_points).max() == pytest.approx(np.abs(fresh.stress_at_points).max(), rel=0.2)


def test_a_body_is_a_mesh_of_pyvista_with_fields_named_with_their_units(run: Run) -> None:
    grid = run.body("fixed", CYCLE, "end-forward")
    assert isinstance(grid, pyvista.UnstructuredGrid)
    units = ("_um", "_MPa")
    names = [name for name in grid.point_data if name != "gripped"]
    assert len(names) == 8
    assert all(name.endswith(units) for name in names)
    assert grid.cell_data["scaled_jacobian"].min() >= 0.2
    # The wire lies above the contact, across the motion, and is pressed upwards.
    assert grid.bounds[4] == pytest.approx(-0.5, abs=0.1)
    assert np.ptp(grid.points[:, 1]) == pytest.approx(1000.0)
    pressed = grid.point_data["contact_traction_MPa"]
    assert pressed[:, 2].max() > 500.0
    assert pressed[:, 2].min() >= -1e-9
    principal = grid.point_data["principal_MPa"]
    np.testing.assert_allclose(grid.point_data["tresca_MPa"], principal[:, 0] - principal[:, 2])
    assert grid.point_data["displacement_um"][grid.point_data["gripped"] > 0.0].any() == np.False_


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


@pytest.mark.slow
def test_the_command_writes_what_paraview_reads_and_draws_it(stored: Path, tmp_path: Path) -> None:
    places = ["--at", "mid-forward", "--at", "end-forward"]
    asked = ["--cycle", "100", *places, "--integration-points", "--animate", "--output", str(tmp_path)]
    outcome = CliRunner().invoke(cli, ["fields", str(stored), *asked], catch_exceptions=False)
    assert outcome.exit_code == 0, outcome.output
    series = pyvista.PVDReader(tmp_path / "cycle_0000100.pvd")
    blocks = series.read()
    assert series.time_values == pytest.approx([0.75, 1.0])
    assert len(blocks) == 2
    for block in blocks:
        quality = block.cell_quality("scaled_jacobian")
        assert quality.cell_data["scaled_jacobian"].min() >= 0.2
        assert (block.celltypes == pyvista.CellType.HEXAHEDRON).all()
        assert block.point_data["stress_MPa"].shape == (block.n_points, 6)
    assert shows(tmp_path / "section_0000100_005.png", *STRESS_COLOURS([0.35, 0.65, 0.95]), part=PANELS)
    assert shows(tmp_path / "cut_0000100_005.png", "#50545a", part=PANELS)
    assert shows(tmp_path / "tractions_0000100_005.png", PRESSURE_COLOURS(0.98), INK, part=PANELS)
    with Image.open(tmp_path / "cycle_0000100.gif") as animation:
        assert animation.format == "GIF"
        assert animation.n_frames == 2  # type: ignore[attr-defined]


def test_where_the_wires_are_apart_files_are_written_and_nothing_is_drawn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # As on a terminal.
    monkeypatch.setenv("FORCE_COLOR", "1")
    made = run_with_forces()
    apart = tuple(replace(forces, force_N=np.zeros_like(forces.force_N)) for forces in made.contact_forces)
    write_result(tmp_path / "result.h5", replace(made, contact_forces=apart))
    asked = ["fields", str(tmp_path), "--cycle", "100", "--output", str(tmp_path / "fields")]
    outcome = CliRunner().invoke(cli, asked, catch_exceptions=False)
    assert outcome.exit_code == 0, outcome.output
    assert "solving" in outcome.stderr
    assert "writing" in outcome.stderr
    assert "the bodies are apart there, of which no picture is drawn" in outcome.stderr
    assert {path.suffix for path in (tmp_path / "fields").iterdir()} == {".vtu", ".pvd"}


def test_a_cycle_that_is_not_recorded_is_one_sentence(stored: Path, tmp_path: Path) -> None:
    outcome = CliRunner().invoke(cli, ["fields", str(stored), "--cycle", "5000", "--output", str(tmp_path)])
    assert outcome.exit_code == 2
    assert "logged cycles are: 100" in outcome.output


def test_every_recorded_position_is_one_state(run: Run) -> None:
    assert [state.position for state in body_states(run, "moving", CYCLE)] == list(range(POSITIONS))
    assert isinstance(run.forces(CYCLE, "moving"), ContactForces)


def test_a_cycle_that_stands_for_another_one_is_said(tmp_path: Path) -> None:
    write_result(tmp_path / "result.h5", run_with_forces())
    asked = ["fields", str(tmp_path), "--cycle", "77", "--no-pictures", "--output", str(tmp_path / "fields")]
    outcome = CliRunner().invoke(cli, asked, catch_exceptions=False)
    assert outcome.exit_code == 0, outcome.output
    assert "cycle 77 is not recorded, 100 is taken; recorded are 100." in outcome.stderr
