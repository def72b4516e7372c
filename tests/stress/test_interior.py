"""The whole body from its patch's forces: the same motion as the compliance, exact stresses, equilibrium."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import pyvista
from threadpoolctl import threadpool_info, threadpool_limits

from geometry import BodyMesh, Elastic, Flat, GradedAxis, HexMesh, PlanarGeometry, build_body, build_planar
from geometry.arrays import Array
from solvers import condense
from solvers.elasticity.linear_elasticity import hydrostatic, integration_points, principal, turned, von_mises
from solvers.stress.interior import Interior, Shared
from tests import bodies
from tests.commands import wirewear
from tests.stress.interior_runs import CYCLE, FRICTION, LOAD_N, DEPTH_um, run_with_forces
from wirewear.app.api.run import Run, read_result
from wirewear.results import write_result
from wirewear.stress import body_grid, body_states, integration_point_cloud
from wirewear.stress.bodies import Section, fanned, section
from wirewear.stress.line_contacts import LineBody
from wirewear.stress.planes import crossland, smith_watson_topper
from wirewear.stress.state import averaging
from wirewear.stress.strength import StrengthAsked, strength_of, stresses_of, yield_sentence


@pytest.fixture(scope="module")
def wire() -> BodyMesh:
    return bodies.wire(0.02)


def held(mesh: HexMesh) -> Interior:
    return Interior(mesh, bodies.STEEL, mesh.surface_nodes("grip"))


def test_the_patch_moves_as_its_compliance_says_under_forces_of_no_symmetry(wire: BodyMesh) -> None:
    interior = held(wire.mesh)
    assert interior.planes == (0, 1)
    nodes = wire.patch.nodes.ravel()
    forces = np.random.default_rng(3).normal(size=(2, len(nodes), 3))
    moved = interior.displacements(nodes, forces)[:, nodes]
    compliance = condense(wire.mesh, wire.patch, bodies.STEEL).compliance
    expected = (compliance @ forces.reshape(2, -1).T).T.reshape(moved.shape)
    np.testing.assert_allclose(moved, expected, atol=1e-10 * np.abs(expected).max())


def test_what_is_far_from_wear_is_eliminated_once_for_all_states_of_a_body(wire: BodyMesh) -> None:
    nodes, size, moving = wire.patch.nodes.ravel(), wire.patch.smallest_element, wire.beneath_patch(1.0)
    along, across = (wire.patch.grid() / np.ptp(wire.patch.grid(), axis=0)).T
    depth = 0.2 * size * np.clip(1.0 - 16.0 * (along**2 + across**2), 0.0, None).reshape(wire.patch.shape)
    forces = np.random.default_rng(5).normal(size=(3, len(nodes), 3))
    meshes = wire.mesh, wire.worn(depth, moving).mesh
    assert moving.mean() < 0.5
    assert np.array_equal(meshes[0].points[~moving], meshes[1].points[~moving])
    grip, shared = wire.mesh.surface_nodes("grip"), Shared()
    found = []
    for mesh in meshes:
        states = held(mesh), Interior(mesh, bodies.STEEL, grip, moving=moving, shared=shared)
        (own, whole), (moved, stress) = (
            (moved := one.displacements(nodes, forces), one.stresses(moved, np.arange(len(mesh.points))))
            for one in states
        )
        np.testing.assert_allclose(moved, own, atol=1e-9 * np.abs(own).max())
        np.testing.assert_allclose(stress, whole, atol=1e-9 * np.abs(whole).max())
        found.append(own)
    assert np.abs(found[1] - found[0]).max() > 1e-3 * np.abs(found[0]).max()
    assert (len(shared.eliminated), len(shared.projections)) == (2, 1)


def test_forces_reach_the_grip_whole_with_their_moments(wire: BodyMesh) -> None:
    mesh, nodes = wire.mesh, wire.patch.nodes.ravel()
    interior = held(mesh)
    forces = np.random.default_rng(4).normal(size=(1, len(nodes), 3))
    points = integration_points(mesh)
    inner = points.internal_forces(points.stresses(bodies.STEEL, interior.displacements(nodes, forces)[0]))
    inner[nodes] -= forces[0]
    reaction = inner[interior.held]
    np.testing.assert_allclose(reaction.sum(axis=0), -forces[0].sum(axis=0), rtol=1e-8)
    moment = np.cross(mesh.points[nodes], forces[0]).sum(axis=0)
    np.testing.assert_allclose(np.cross(mesh.points[interior.held], reaction).sum(axis=0), -moment, rtol=1e-8)
    assert np.abs(np.delete(inner, interior.held, axis=0)).max() < 1e-10


def test_a_linear_displacement_has_the_exact_stress_everywhere_on_a_distorted_mesh() -> None:
    mesh = bodies.brick((3, 3, 3), (1.0, 0.8, 0.7), distortion=0.3)
    gradient = np.array([[1e-3, 2e-4, -3e-4], [0.0, -2e-4, 4e-4], [1e-4, 0.0, 5e-4]])
    strain = 0.5 * (gradient + gradient.T)
    shear = bodies.STEEL.shear_modulus_MPa
    lame = 2.0 * shear * 0.3 / 0.4
    exact = 2.0 * shear * strain + lame * np.trace(strain) * np.eye(3)
    points = integration_points(mesh)
    stress = points.stresses(bodies.STEEL, mesh.points @ gradient.T)
    expected = exact[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]
    np.testing.assert_allclose(stress, np.broadcast_to(expected, stress.shape), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(points.at_nodes(stress), np.tile(expected, (len(mesh.points), 1)), rtol=1e-5, atol=1e-4)
    assert points.volumes.sum() == pytest.approx(mesh.volume_mm3(), rel=1e-12)


def test_stresses_of_several_displacements_are_projected_on_one_side_as_each_on_the_whole_body(wire: BodyMesh) -> None:
    interior, points = Interior(wire.mesh, bodies.STEEL, wire.mesh.surface_nodes("grip")), integration_points(wire.mesh)
    assert len(interior.planes) == 2
    moved = np.random.default_rng(5).normal(size=(2, len(wire.mesh.points), 3))
    each = np.array([points.at_nodes(points.stresses(bodies.STEEL, one)) for one in moved])
    nodes = np.random.default_rng(6).permutation(len(wire.mesh.points))[:99]
    np.testing.assert_allclose(interior.stresses(moved, nodes), each[:, nodes], atol=1e-6 * np.abs(each).max())


def test_forces_symmetric_but_for_the_error_of_a_contacts_solution_are_solved_by_one_factor(wire: BodyMesh) -> None:
    interior, nodes = Interior(wire.mesh, bodies.STEEL, wire.mesh.surface_nodes("grip")), wire.patch.nodes.ravel()
    forces = np.zeros((1, len(nodes), 3))
    forces[..., 2] = -1.0
    interior.displacements(nodes, forces + 1e-11 * np.random.default_rng(7).normal(size=forces.shape))
    assert len(interior.shared.eliminated) == 1


def test_equivalent_stresses_of_plain_states() -> None:
    tension = np.array([100.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    shear = np.array([0.0, 0.0, 0.0, 100.0, 0.0, 0.0])
    assert (von_mises(tension), hydrostatic(tension)) == pytest.approx((100.0, 100.0 / 3.0))
    assert von_mises(shear) == pytest.approx(100.0 * np.sqrt(3.0))
    np.testing.assert_allclose(principal(shear), [100.0, 0.0, -100.0], atol=1e-9)
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(turned(tension, quarter), [0.0, 100.0, 0.0, 0.0, 0.0, 0.0], atol=1e-9)


def test_an_elastic_grip_gives_the_patch_its_compliance_too() -> None:
    wire = build_body(
        replace(bodies.wire_geometry(0.02, 0.02, 0.04), grip_stiffness_N_per_mm3=1e5, grip_half_length_mm=0.3)
    )
    grip = wire.mesh.surface_nodes("grip")
    assert np.abs(wire.mesh.points[grip, 0]).max() < 0.45
    assert wire.bedding is not None
    held_area = wire.bedding.sum() / 1e5
    assert held_area == pytest.approx(wire.mesh.surface_areas("grip").sum())
    nodes = wire.patch.nodes.ravel()
    body = condense(wire.mesh, wire.patch, bodies.STEEL, bedding=wire.bedding)
    assert body.folded.planes == (0, 1)
    forces = np.random.default_rng(6).normal(size=(1, len(nodes), 3))
    everywhere = Interior(wire.mesh, bodies.STEEL, grip[:0], wire.bedding).displacements(nodes, forces)[0]
    expected = body.compliance @ forces.ravel()
    np.testing.assert_allclose(everywhere[nodes].ravel(), expected, atol=1e-10 * np.abs(expected).max())
    # What the springs push back is what the contact gives.
    pushed = (wire.bedding[:, None] * everywhere).sum(axis=0)
    np.testing.assert_allclose(pushed, forces[0].sum(axis=0), rtol=1e-8)


STEEL = Elastic(200_000.0, 0.3)
PHASE = np.linspace(0.0, 2.0 * np.pi, 25)


def history(tensor: Array, course: Array) -> Array:
    """A tensor (3, 3) times a course (s,), as six components of one point."""
    six = np.array([tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 1], tensor[1, 2], tensor[0, 2]])
    return np.asarray((course[:, None] * six)[:, None, :])


def rotation(seed: int) -> Array:
    return np.asarray(np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0])


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_in_reversed_tension_the_critical_plane_lies_across_it_whatever_its_direction(seed: int) -> None:
    turn = rotation(seed)
    pull = turn @ np.diag([300.0, 0.0, 0.0]) @ turn.T
    found = smith_watson_topper(history(pull, np.cos(PHASE)), STEEL)
    assert found.parameter[0] == pytest.approx(300.0**2 / 200_000.0, rel=1e-4)
    assert abs(found.normal[0] @ turn[:, 0]) == pytest.approx(1.0, abs=1e-4)


def test_pulsating_tension_keeps_the_largest_stress_and_halves_the_strain_amplitude() -> None:
    pull = np.diag([300.0, 0.0, 0.0])
    found = smith_watson_topper(history(pull, 0.5 * (1.0 + np.cos(PHASE))), STEEL)
    assert found.parameter[0] == pytest.approx(300.0 * 150.0 / 200_000.0, rel=1e-4)


def test_crossland_of_reversed_shear_and_of_tension() -> None:
    shear = np.zeros((3, 3))
    shear[0, 1] = shear[1, 0] = 100.0
    turn = rotation(4)
    found = crossland(history(turn @ shear @ turn.T, np.cos(PHASE)))
    assert found.amplitude_MPa[0] == pytest.approx(100.0, rel=1e-3)
    assert found.hydrostatic_MPa[0] == pytest.approx(0.0, abs=1e-9)
    pulled = crossland(history(np.diag([300.0, 0.0, 0.0]), np.cos(PHASE)))
    assert pulled.amplitude_MPa[0] == pytest.approx(300.0 / np.sqrt(3.0), rel=1e-3)
    assert pulled.equivalent_MPa(0.3)[0] == pytest.approx(300.0 / np.sqrt(3.0) + 30.0, rel=1e-3)


def test_the_amplitude_of_a_circular_path_is_its_radius_and_a_constant_stress_has_none() -> None:
    """Out-of-phase tension and shear of equal deviatoric size: the path is a circle, every diameter as long."""
    path = np.zeros((25, 1, 6))
    path[:, 0, 0] = np.sqrt(3.0) * 100.0 * np.cos(PHASE)
    path[:, 0, 3] = 100.0 * np.sin(PHASE)
    path[:, 0, 4] = 500.0
    assert crossland(path).amplitude_MPa[0] == pytest.approx(100.0, rel=0.02)
    assert crossland(path[:1].repeat(5, axis=0)).amplitude_MPa[0] == pytest.approx(0.0, abs=1e-9)


def test_averages_keep_linear_fields_and_a_length_of_zero_changes_nothing() -> None:
    lines = np.linspace(-1.0, 1.0, 21)
    points = np.stack(np.meshgrid(lines, lines, lines, indexing="ij"), axis=-1).reshape(-1, 3)
    volumes = np.ones(len(points))
    middle = np.array([len(points) // 2])
    field = points @ [1.0, -2.0, 0.5] + 3.0
    assert (averaging(points, volumes, middle, 0.65) @ field)[0] == pytest.approx(3.0)
    bump = (points**2).sum(axis=1)
    # Over a ball of radius a the mean of r² is 3 a² / 5.
    assert (averaging(points, volumes, middle, 1.6) @ bump)[0] == pytest.approx(0.6 * 0.8**2, rel=0.03)
    assert (averaging(points, volumes, middle, 0.0) @ bump)[0] == bump[middle[0]]


@pytest.mark.seconds
def test_averaging_lowers_the_peaks_of_a_wire_and_yield_follows_the_stated_strength() -> None:
    run = run_with_forces()
    sharp = strength_of(run, "fixed", CYCLE, StrengthAsked(100.0))
    smooth = strength_of(run, "fixed", CYCLE, StrengthAsked(1e5, averaging_length_um=60.0))
    for name in ("von_mises", "critical_plane", "crossland"):
        assert getattr(smooth, name).value_MPa < getattr(sharp, name).value_MPa, name
    assert (sharp.yields, smooth.yields) == (True, False)
    assert "yields at 100 MPa from cycle 100" in yield_sentence([sharp])
    assert "to cycle 100, the last one looked at. Stresses beyond yield are" in yield_sentence([sharp])
    flowed = replace(sharp, flowed=True)
    assert "elastic ones, residual stress included: metal flows" in yield_sentence([flowed])
    # Friction turns: most of what yields does so both ways.
    assert 0.5 * sharp.von_mises.value_MPa < sharp.swing.value_MPa < sharp.von_mises.value_MPa
    assert "flows in every cycle until 100" in yield_sentence([sharp])
    still = replace(sharp, swing=replace(sharp.swing, value_MPa=99.0))
    assert "swing by ±99 MPa at most, so it can shake down" in yield_sentence([still])
    relieved = replace(smooth, cycle=200, asked=sharp.asked, von_mises=replace(smooth.von_mises, value_MPa=50.0))
    assert "to cycle 100; the next one looked at, 200, does not. Stresses" in yield_sentence([sharp, relieved])
    assert "nothing yields" in yield_sentence([smooth])
    assert sharp.grid.point_data["smith_watson_topper_MPa"].max() == sharp.critical_plane.value_MPa
    # The shear is reversed in the same place: cracks begin at the surface, at both edges alike.
    assert sharp.critical_plane.depth_um < 1.0
    assert abs(sharp.critical_plane.x_um) > 10.0


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
    cut = fanned(points, points @ [3.0, -1.0], [np.array([0, 1, 2, 3]), np.array([3, 2, 4])])
    x, z = cut.along[cut.triangles], cut.height[cut.triangles]
    areas = 0.5 * ((x[:, 1] - x[:, 0]) * (z[:, 2] - z[:, 0]) - (x[:, 2] - x[:, 0]) * (z[:, 1] - z[:, 0]))
    assert areas.min() > 0.0
    assert areas.sum() == pytest.approx(3.0)
    assert cut.values == pytest.approx(3.0 * cut.along - cut.height)


@pytest.fixture(scope="module")
def run() -> Run:
    return Run.of(run_with_forces())


def test_strengths_are_found_by_one_thread(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Threads of linear algebra that wait for each other took four times the time on a busy machine."""
    threads: list[int] = []

    def projected(*_: object) -> None:
        threads.extend(one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas")
        raise KeyboardInterrupt

    monkeypatch.setattr(Interior, "stresses", projected)
    with threadpool_limits(2, user_api="blas"), pytest.raises(KeyboardInterrupt):
        strength_of(run, "fixed", CYCLE, StrengthAsked())
    assert set(threads) == {1}


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
    points = state.body.points
    by_grip = points.internal_forces(points.stresses(state.body.material, state.displacement)) - state.applied
    total = by_grip[state.body.mesh.surface_nodes("grip")].sum(axis=0) @ state.to_world.T
    sign = 1.0 if wire == "moving" else -1.0
    # The moving wire goes forward, so friction drives the fixed one along +x.
    expected = sign * np.array([FRICTION * LOAD_N, 0.0, LOAD_N])
    np.testing.assert_allclose(total, expected, rtol=1e-5, atol=1e-5 * LOAD_N)
    assert state.forces.tangential_force_N[state.position] == pytest.approx(FRICTION * LOAD_N)


@pytest.mark.seconds
def test_nodes_stand_in_the_worn_surface_in_sound_elements(run: Run) -> None:
    worn, fresh = (body_states(run, "fixed", CYCLE, [0], worn=worn)[0] for worn in (True, False))
    patch = worn.body.patch
    middle = patch.nodes[patch.shape[0] // 2, patch.shape[1] // 2]
    mesh, before = worn.body.mesh, fresh.body.mesh
    assert mesh.points[middle, 2] - before.points[middle, 2] == pytest.approx(-1e-3 * DEPTH_um)
    assert mesh.scaled_jacobians().min() >= 0.2
    # Beneath a shallow bowl the stress is nearly that of the fresh wire under the same forces.
    assert np.abs(worn.stress_at_points).max() == pytest.approx(np.abs(fresh.stress_at_points).max(), rel=0.2)


def test_of_a_symmetric_cycle_half_is_computed_and_the_other_half_is_its_mirror_image(run: Run) -> None:
    states = body_states(run, "moving", CYCLE, ["mid-forward", "mid-back"])
    interior, force = states[0].body.interior, np.array([state.forces.force_N[state.position] for state in states])
    # Beside a bulk stress that differs, neither state is the image of the other.
    assert len(interior.cycle_image(states[0].loaded_nodes, force, np.array([[1.0], [2.0]])).computed) == 2
    assert len(interior.cycle_image(states[0].loaded_nodes, force, np.ones((2, 1))).computed) == 1
    nodes = states[0].loaded_nodes
    each = np.array([state.stress[nodes] for state in states])
    assert stresses_of(states, nodes) == pytest.approx(each, abs=1e-6 * np.abs(each).max())


def test_stroke_and_its_mirror_image_give_mirrored_fields(run: Run) -> None:
    there, back = (run.body("moving", CYCLE, at) for at in ("mid-forward", "mid-back"))
    order, mirrored = (np.lexsort(np.round(p, 6).T) for p in (there.points, back.points * [-1.0, 1.0, 1.0]))
    np.testing.assert_allclose(
        there.point_data["von_mises_MPa"][order], back.point_data["von_mises_MPa"][mirrored], rtol=1e-6, atol=1e-4
    )


def test_integration_points_lie_in_the_body_with_what_the_elements_compute(run: Run) -> None:
    (state,) = body_states(run, "fixed", CYCLE, [0])
    cloud = integration_point_cloud(state)
    assert cloud.n_points == 8 * len(state.body.mesh.cells)
    assert cloud.point_data["stress_MPa"].shape == (cloud.n_points, 6)
    grid = body_grid(state)
    mean = cloud.point_data["von_mises_MPa"].reshape(-1, 8).mean(axis=1)
    np.testing.assert_allclose(mean, grid.cell_data["von_mises_MPa"], rtol=1e-9)


@pytest.mark.seconds
def test_a_cycle_that_stands_for_another_one_is_said(tmp_path: Path) -> None:
    write_result(tmp_path / "result.h5", run_with_forces())
    asked = ["fields", str(tmp_path), "--cycle", "77", "--no-pictures", "--output", str(tmp_path / "fields")]
    assert "cycle 77 is not recorded, 100 is taken; recorded are 100." in wirewear(*asked).stderr


@pytest.mark.parametrize("axis_mm", [-10.0, 10.0])
def test_inside_a_ring_stresses_are_those_of_lame_and_saint_venant(axis_mm: float) -> None:
    """A solid shaft, and a hub of twice its radius: far from the held end, under even pressure and even turning."""
    half, radius, pressure = 50.0, 10.0, 100.0
    lines = GradedAxis(0.5, half - 0.01, 0.5, half - 0.01)
    ring = build_planar(PlanarGeometry(Flat(), half, 10.0, lines, growth=1.2, axis_mm=axis_mm, held_end=1))
    body = LineBody.of(ring, bodies.STEEL)
    nodes, width = ring.patch.nodes.ravel(), ring.patch.node_areas()
    forces = np.zeros((2, len(nodes), 3))
    forces[0, :, 2], forces[1, :, 1] = -pressure * width, width
    moved = body.interior.displacements(nodes, forces)
    compliance = condense(ring.mesh, ring.patch, bodies.STEEL).compliance
    np.testing.assert_allclose(
        moved[:, nodes].reshape(2, -1), forces.reshape(2, -1) @ compliance, atol=1e-9 * np.abs(moved).max()
    )
    places = body.points.positions.reshape(-1, 2)
    middle = np.abs(places[:, 0]) < 0.5
    r = np.abs(places[middle, 1] - axis_mm)
    inner, outer = (0.0, radius) if axis_mm < 0.0 else (radius, 2.0 * radius)
    squeezed, turned = (body.points.stresses(bodies.STEEL, one).reshape(-1, 6)[middle] for one in moved)
    beyond = (outer / r) ** 2 if inner else -np.ones_like(r)
    share = radius**2 / (outer**2 - inner**2)
    np.testing.assert_allclose(
        squeezed[:, 1], pressure * share * (1.0 + beyond) if inner else -pressure, atol=0.03 * pressure
    )
    torque = 2.0 * np.pi * radius**2 * (half + places[middle, 0])
    polar = 0.5 * np.pi * (outer**4 - inner**4)
    np.testing.assert_allclose(np.abs(turned[:, 3]), torque * r / polar, rtol=0.03, atol=0.01)
    surface = nodes[[len(nodes) // 2]]
    ((at_surface,), _) = body.interior.stresses(moved, surface)
    exact = (outer**2 + radius**2) / (outer**2 - radius**2) if inner else -1.0
    assert at_surface[1] == pytest.approx(pressure * exact, rel=0.02)
