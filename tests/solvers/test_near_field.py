"""What elements lack near a loaded node: checked against closed forms of the half-space and by symmetry."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from geometry import Elastic, Flat, GradedAxis, HexMesh, PlanarGeometry, RimGradedAxis, build_planar
from geometry.arrays import Array
from solvers import PlacedBody, advance, facing, place, press, unloaded_state
from solvers.elasticity.linear_elasticity import integration_points
from solvers.elasticity.patch_compliance import Bricks, half_space_response, missing_displacement, reach
from solvers.stress.body_forces import forces_on_bodies
from solvers.stress.interior import Interior
from solvers.stress.lattice_error import line_lattice_error
from solvers.stress.line_surface_stress import LineSurfaceStress, LoadedLine
from solvers.stress.nearby_tractions import half_space_stress
from solvers.stress.subgrid_traction import SubgridTraction, fitted_square
from solvers.stress.surface_stress import LoadedSurface, SurfaceStress, unspread, window_lines
from solvers.transfer import hat_products, hats
from tests import bodies
from tests.bodies import STEEL
from wirewear import reference
from wirewear.verification import FULL
from wirewear.verification.line_contact import (
    MATERIAL,
    LOAD_N_per_mm,
    cylinder_on_flat,
    line_surface_rows,
    pad_geometry,
)

FINE_mm = 0.004
LAYERS = (0.6 * FINE_mm, 1.3)
CROSSED = ((0.0, 1.0), (1.0, 0.0))


def _bodies(angle_rad: float = np.pi / 2) -> tuple[PlacedBody, PlacedBody]:
    """Crossed wires, upper and lower, as the elements answer."""
    body = bodies.condensed_wire(FINE_mm)
    return place(body, upper=True, axis_angle_rad=angle_rad), place(body, upper=False, axis_angle_rad=0.0)


def _pair_along_z(primary: PlacedBody, secondary: PlacedBody, offset_mm: tuple[float, float]) -> Array:
    """How two wires crossed at right angles approach at the primary's nodes by unit forces there, (n, n), mm/N.

    The secondary is shifted by an offset along the primary's axes.
    """
    own, other = primary.patch, secondary.patch
    along = hat_products(own.axial_mm, other.transverse_mm + offset_mm[0])
    across = hat_products(own.transverse_mm, other.axial_mm + offset_mm[1])
    # The secondary's nodes are numbered along its own axis first.
    averaged = np.einsum("at,cs->acst", along, across).reshape(own.size, other.size) / own.node_areas()[:, None]
    return np.asarray(primary.compliance[2::3, 2::3] + averaged @ secondary.compliance[2::3, 2::3] @ averaged.T)


def _love(x: Array, y: Array, a: float, b: float) -> Array:
    """Mean of 1/r between two rectangles a by b whose centres are (x, y) apart, by its fourth antiderivative."""

    def antiderivative(x: Array, y: Array) -> Array:
        r = np.hypot(x, y)
        first = np.where(y == 0.0, 0.0, x * y**2 * np.arcsinh(x / np.where(y == 0.0, 1.0, np.abs(y))))
        second = np.where(x == 0.0, 0.0, x**2 * y * np.arcsinh(y / np.where(x == 0.0, 1.0, np.abs(x))))
        return np.asarray(0.5 * (first + second) - r**3 / 6.0)

    weights = ((-1, 1), (0, -2), (1, 1))
    total = sum(m * n * antiderivative(x + i * a, y + j * b) for i, m in weights for j, n in weights)
    return np.asarray(total / (a * b) ** 2)


def _error_against_cells(matrix: Array, patch_shape: tuple[int, int], size: tuple[float, float]) -> float:
    """Worst error of the responses about the middle node, less that four elements away, over the closed form's own."""
    n_a, n_t = patch_shape
    middle = (n_a // 2) * n_t + n_t // 2
    i, j = (np.indices((9, 9)) - 4).reshape(2, -1)
    nu, modulus = bodies.STEEL.poissons_ratio, bodies.STEEL.youngs_modulus_MPa
    exact = 2.0 * (1.0 - nu**2) / (np.pi * modulus) * _love(np.asarray(i * size[0]), np.asarray(j * size[1]), *size)
    found = matrix[middle, middle + i * n_t + j]
    rim = np.maximum(np.abs(i), np.abs(j)) == 4
    # The wires' bulk moves all nodes alike.
    found = found - (found - exact)[rim].mean()
    return float(np.abs(found - exact).max() / exact.max())


@pytest.mark.slow
def test_a_loaded_node_gives_way_as_its_cell_does_between_two_half_spaces() -> None:
    upper, lower = _bodies()
    size = (float(np.diff(upper.patch.axial_mm)[8]), float(np.diff(upper.patch.transverse_mm)[8]))
    h = size[0]
    offsets = [(u * h, v * h) for u in (0.0, 0.25, 0.5, 0.75) for v in (0.0, 0.25, 0.5, 0.75)]
    corrected = facing(upper, lower)
    before, after = (
        _error_against_cells(
            np.mean([_pair_along_z(body, lower, offset) for offset in offsets], axis=0), body.patch.shape, size
        )
        for body in (upper, corrected)
    )
    assert before > 0.2
    assert after < 0.05


def test_an_even_pressure_on_a_large_area_is_answered_as_before() -> None:
    steel = Bricks(bodies.STEEL, LAYERS)
    near = missing_displacement(steel, (FINE_mm, FINE_mm), steel, (FINE_mm, FINE_mm), CROSSED)
    assert np.abs(near.sum(axis=(0, 1))).max() < 1e-12 * np.abs(near).max()


@pytest.mark.parametrize("sizes", [((0.004, 0.004), (0.004, 0.004)), ((0.012, 0.005), (0.006, 0.018))])
def test_what_is_lacking_fades_within_a_few_elements_and_is_symmetric(sizes: tuple[tuple[float, float], ...]) -> None:
    own, other = sizes
    bricks = [Bricks(Elastic(210_000.0, 0.3), (0.6 * min(size), 1.3)) for size in sizes]
    near = missing_displacement(bricks[0], own, bricks[1], other, CROSSED)
    a, t = reach(own)
    largest = np.abs(near[a, t]).max()
    x, y = np.meshgrid(np.arange(-a, a + 1) * own[0], np.arange(-t, t + 1) * own[1], indexing="ij")
    far = np.hypot(x, y) > 5.0 * max(own + other)
    assert not far.any() or np.abs(near[far]).max() < 0.01 * largest
    np.testing.assert_allclose(near, near[::-1, ::-1].swapaxes(-1, -2), atol=1e-12 * largest)


def test_waves_on_a_half_space_agree_with_boussinesq_and_cerruti() -> None:
    # Summed over waves, the response to a narrow Gaussian load is that to a point force farther away.
    n, step, width = 256, 0.1, 0.25
    numbers = 2.0 * np.pi * np.fft.fftfreq(n, step)
    kx, ky = (each.ravel() for each in np.meshgrid(numbers, numbers, indexing="ij"))
    material = Elastic(1.0, 0.3)
    spectrum = half_space_response(kx, ky, material) * np.exp(-0.5 * width**2 * (kx**2 + ky**2))[:, None, None]
    found = np.fft.ifft2(spectrum.reshape(n, n, 3, 3), axes=(0, 1)).real / step**2

    def exact(x: float, y: float) -> Array:
        nu, r = 0.3, np.hypot(x, y)
        along = (1.0 + nu) / np.pi * np.array([(1.0 - nu) / r + nu * x**2 / r**3, (1.0 - nu) / r + nu * y**2 / r**3])
        return np.array([*along, (1.0 - nu**2) / (np.pi * r), (1.0 - 2.0 * nu) * (1.0 + nu) * x / (2.0 * np.pi * r**2)])

    def at(i: int, j: int) -> Array:
        u = found[i, j]
        return np.array([u[0, 0], u[1, 1], u[2, 2], u[0, 2]])

    # The mean of a periodic field is lost, so differences are compared.
    np.testing.assert_allclose(at(15, 0) - at(30, 0), exact(1.5, 0.0) - exact(3.0, 0.0), rtol=0.05)


@pytest.mark.seconds
def test_the_corrected_compliance_is_symmetric_and_positive_definite() -> None:
    for angle in (np.pi / 2, 1.0):
        upper, lower = _bodies(angle)
        for one, other in ((upper, lower), (lower, upper)):
            compliance = facing(one, other).compliance
            np.testing.assert_allclose(compliance, compliance.T, atol=1e-14)
            assert np.linalg.eigvalsh(compliance)[0] > 0.0


NU, FRICTION = 0.3, 0.62


def hertz(per_radius: float, centre: tuple[float, float]) -> Array:
    """Nodal tractions of a contact that slides towards +x, of unit radius and pressure; its own traction along −x."""
    lines = np.arange(-2.5, 2.5 + 1e-9, 1.0 / per_radius)
    x, y = np.meshgrid(lines - centre[0], lines - centre[1], indexing="ij")
    pressure = np.sqrt(np.maximum(1.0 - x**2 - y**2, 0.0))
    return np.stack([-FRICTION * pressure, 0.0 * pressure, -pressure], axis=-1)


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize("centre", [(0.0, 0.0), (0.11, 0.05)])
@pytest.mark.parametrize("per_radius", [4.0, 24.0])
def test_between_nodes_hertzs_pressure_ends_on_its_circle(per_radius: float, centre: tuple[float, float]) -> None:
    between = SubgridTraction.of_nodes(hertz(per_radius, centre))
    places = between.edge() / per_radius - 2.5 - centre
    assert len(places) > 20
    np.testing.assert_allclose(np.hypot(*places.T), 1.0, atol=0.08 / per_radius)
    middle = int(2.5 * per_radius)
    np.testing.assert_allclose(between.ratio[middle, middle], [-FRICTION, 0.0, -1.0])


def flat(size_mm: float = 1.0, elements: int = 16, depth: int = 10) -> SurfaceStress:
    step = size_mm / elements
    mesh = bodies.brick((elements, elements, depth), (size_mm, size_mm, depth * step))
    mesh = HexMesh(mesh.points, mesh.cells, {**mesh.surfaces, "contact": mesh.surfaces["top"]})
    return SurfaceStress(mesh, bodies.patch_on(mesh), bodies.STEEL, (step, 1.0))


@pytest.mark.slow
@pytest.mark.parametrize("x", [-1.0, -0.6, 0.0, 0.8, 1.3])
def test_rays_sum_hertzs_tractions_to_hamiltons_stress(x: float) -> None:
    between = SubgridTraction.of_nodes(hertz(4.0, (0.0, 0.0)))
    # A node stands at the edge, just inside of which the stress is to be taken.
    at = np.sign(x) * (between.edge() / 4.0 - 2.5)[:, 0].max() if abs(x) == 1.0 else x
    place = np.array([[4.0 * (at + 2.5), 10.0]])
    found = half_space_stress(place, np.ones(2), between.square, between.ratio, True, NU)[0]
    # The body lies below, its normal points out: the closed form's z axis points in.
    exact = reference.sliding_stress(
        x, 0.0, 0.0, contact_radius_mm=1.0, peak_pressure_MPa=1.0, peak_shear_MPa=-FRICTION, poissons_ratio=NU
    )
    np.testing.assert_allclose(found[:4], exact[:4], atol=0.04)


@pytest.mark.seconds
def test_a_contact_that_leaves_the_elements_alike_is_not_corrected_there_and_its_mirror_image_neither() -> None:
    surface = flat(5.0, 20)
    grid = surface.patch.grid()
    traction = hertz(4.0, (0.0, 1.9))
    there, back = (LoadedSurface(surface, one).correction(grid) for one in (traction, traction[:, ::-1]))
    shape = surface.patch.shape
    # Seen from the other side, shears with y turn round.
    turned = back.reshape(*shape, 6)[:, ::-1].reshape(-1, 6) * [1.0, 1.0, 1.0, -1.0, -1.0, 1.0]
    np.testing.assert_allclose(there, turned, atol=1e-9)
    assert not there[(grid[:, 1] > 1.75) & (np.abs(grid[:, 0]) < 0.5)].any()
    assert np.abs(there[grid[:, 1] < 1.2]).max() > 0.05
    # What changes little from node to node the elements have.
    assert np.abs(LoadedSurface(surface, hertz(4.0, (0.0, 0.0))).correction(np.zeros((1, 2)))).max() < 0.2


def test_elements_alike_in_proportion_share_one_stencil() -> None:
    # To scale, and apart by round-off, as grids are that were made in another order.
    first, larger = flat(), flat(3.0 * (1.0 + 1e-13))
    assert first.stencil is larger.stencil
    assert first.stencil is not replace(first, layers=(2.0 * first.layers[0], 1.0)).stencil


@pytest.mark.seconds
def test_a_symmetric_contact_is_corrected_on_one_side_of_its_middle_only(monkeypatch: pytest.MonkeyPatch) -> None:
    surface, counts = flat(5.0, 20), []
    loaded = LoadedSurface(surface, hertz(4.0, (0.0, 0.0)))
    assert surface.stencil.any()

    def counted(places: Array, *others: Any) -> Array:
        counts.append(len(places))
        return half_space_stress(places, *others)

    monkeypatch.setattr("solvers.stress.surface_stress.half_space_stress", counted)
    grid = surface.patch.grid()
    np.testing.assert_allclose(loaded.correction(grid), loaded._correction(grid), atol=1e-9)
    assert counts[0] < 0.6 * counts[1]


def hertz_of_stress(per_half_width: float, centre: float = 0.0) -> tuple[Array, Array]:
    """Nodes of a line contact that slides towards +x, of unit half-width and pressure, and tractions that load them as
    it does.
    """
    x, fine = np.arange(-2.5, 2.5 + 1e-9, 1.0 / per_half_width), np.linspace(-2.5, 2.5, 5001)
    pressure = unspread(x, hats(x, fine).T @ np.sqrt(np.maximum(1.0 - (fine - centre) ** 2, 0.0)) * (fine[1] - fine[0]))
    return x, np.stack([-FRICTION * pressure, 0.0 * pressure, -pressure], axis=-1)


def flat_of_stress(half_width_mm: float, fine_mm: float) -> LineSurfaceStress:
    lines = GradedAxis(fine_mm, half_width_mm, fine_mm, half_width_mm)
    return LineSurfaceStress.of(build_planar(PlanarGeometry(Flat(), 20.0, 20.0, lines)), STEEL)


@pytest.mark.parametrize("per_half_width", [6.0, 12.0, 40.0])
@pytest.mark.parametrize("centre", [0.0, 0.03])
def test_between_nodes_hertzs_pressure_ends_at_its_edges_on_any_mesh(per_half_width: float, centre: float) -> None:
    x, traction = hertz_of_stress(per_half_width, centre)
    edges = np.interp(SubgridTraction.of_nodes(traction[:, None]).edge()[:, 0], np.arange(float(len(x))), x)
    np.testing.assert_allclose(np.sort(edges) - centre, [-1.0, 1.0], atol=0.05 / per_half_width)


@pytest.mark.parametrize("off", [-0.17, 0.08])
def test_between_nodes_an_outermost_one_that_is_off_by_what_the_mesh_makes_it_moves_no_edge(off: float) -> None:
    x, traction = hertz_of_stress(18.0, 0.03)
    loaded = np.flatnonzero(traction[:, 2] < -0.05)[[0, -1]]
    # The square falls by 2/18 over the last element.
    off_pressure = np.sqrt(np.maximum(traction[loaded, 2] ** 2 + off * 2.0 / 18.0, 0.0))
    load = traction[:, 2].sum()
    traction[loaded] *= (off_pressure / -traction[loaded, 2])[:, None]
    traction *= load / traction[:, 2].sum()
    edges = np.interp(SubgridTraction.of_nodes(traction[:, None]).edge()[:, 0], np.arange(float(len(x))), x)
    np.testing.assert_allclose(np.sort(edges) - 0.03, [-1.0, 1.0], atol=0.08 / 18.0)


@pytest.mark.parametrize("power", [4, 8])
def test_between_nodes_a_flat_pressure_ends_within_half_an_element_of_its_edge(power: int) -> None:
    x = np.arange(-2.5, 2.5, 1.0 / 18.0)
    pressure = np.sqrt(np.maximum(1.0 - np.abs(x) ** power, 0.0))
    edges = SubgridTraction.of_nodes(np.stack([0.6 * pressure, 0.0 * pressure, -pressure], axis=-1)[:, None]).edge()
    places = np.interp(edges[:, 0], np.arange(float(len(x))), x)
    np.testing.assert_allclose(np.sort(places), [-1.0, 1.0], atol=0.6 / 18.0)


@pytest.mark.seconds
def test_on_the_own_surface_of_each_of_two_bodies_that_slide_shear_is_the_friction_laws_share_of_pressure() -> None:
    problem = cylinder_on_flat(0.012)
    state, _ = press(problem, unloaded_state(problem))
    state, _ = advance(problem, state, 0.02, 0.0)
    forces, pad = forces_on_bodies(problem, state), pad_geometry(0.012)
    shapes = (pad, PlanarGeometry(Flat(), 8.0, 8.0, pad.along))
    for shape, force in zip(shapes, forces, strict=True):
        traction = LineSurfaceStress.of(build_planar(shape), MATERIAL).under(force).traction
        loaded = traction[:, 2] < 0.1 * traction[:, 2].min()
        np.testing.assert_allclose(np.abs(traction[loaded, 0]), -0.6 * traction[loaded, 2], rtol=2e-3)
        assert force[:, 2].sum() == pytest.approx(-LOAD_N_per_mm, rel=1e-3)


def test_one_line_stands_for_tractions_alike_across_it() -> None:
    _, traction = hertz_of_stress(8.0)
    wide = np.repeat(traction[:, None], 61, axis=1)
    line, fitted = (fitted_square(-one[..., 2]) for one in (traction[:, None], wide))
    np.testing.assert_allclose(line[:, 0], fitted[:, 30], atol=1e-9)
    ratios = (SubgridTraction.of_nodes(one).ratio for one in (traction[:, None], wide))
    np.testing.assert_allclose(next(ratios)[:, 0], next(ratios)[:, 30], atol=1e-9)


def test_what_quadrilaterals_lack_is_what_a_mesh_of_them_lacks() -> None:
    """A traction at one node: the mesh's stress near it is the half-plane's plus the lattice's error."""
    surface = flat_of_stress(0.5, 0.02)
    nodes = surface.patch.nodes.ravel()
    middle = len(nodes) // 2
    points = integration_points(surface.mesh)
    held = Interior(surface.mesh, STEEL, surface.mesh.surface_nodes("grip"))
    for component in (0, 2):
        forces = np.zeros((1, len(nodes), 3))
        forces[0, middle - 1 : middle + 2, component] = np.array([1.0, 4.0, 1.0]) / 6.0 * surface.spacing_mm
        found = points.at_nodes(points.stresses(STEEL, held.displacements(nodes, forces)[0]))[nodes]
        expected = surface.stencil[len(nodes) - 1 - middle : 2 * len(nodes) - 1 - middle, :, component]
        near = slice(middle - 8, middle + 9)
        # The last rows of elements beneath are those of a mesh that grows, not of an endless one.
        np.testing.assert_allclose(found[near], expected[near], atol=0.01)
        assert np.abs(found[near]).max() > 0.2


@pytest.mark.seconds
def test_the_half_planes_stress_by_these_tractions_is_mcewens() -> None:
    x, traction = hertz_of_stress(12.0)
    loaded = LoadedLine(flat_of_stress(2.5, 1.0 / 12.0), traction)
    edge = float(loaded.between.edge()[:, 0].min())
    places = np.append([edge], 30.0 + 12.0 * np.array([-0.5, 0.0, 0.7, 1.3]))
    found = np.array([loaded._exact(place) for place in places])
    exact = reference.line_stress(
        np.interp(places, np.arange(float(len(x))), x).clip(-1.0), np.zeros(len(places)), half_width_mm=1.0,
        peak_pressure_MPa=1.0, peak_shear_MPa=-FRICTION, poissons_ratio=NU,
    )  # fmt: skip
    # The body lies below, its normal points out: the closed form's z axis points in.
    np.testing.assert_allclose(found[:, :4], exact[:, :4], atol=0.03)
    np.testing.assert_allclose(found[:, 5], -exact[:, 5], atol=0.015)


@pytest.mark.slow
def test_fine_meshes_have_mcewens_and_cattaneos_tension_behind_a_cylinder() -> None:
    rows = line_surface_rows(FULL)
    assert len(rows) == 4
    assert [row for row in rows if not row.passed] == []


def test_stresses_are_corrected_as_far_as_the_rim_where_elements_shrink_towards_it() -> None:
    graded, fine = RimGradedAxis(1.0, 12, 1.3).lines(), GradedAxis(0.1, 0.5, 0.3, 2.0).lines()
    assert window_lines(graded) is graded
    assert window_lines(fine)[-1] == pytest.approx(0.5, rel=0.01)


def test_between_lines_that_close_up_towards_the_edge_hertz_pressure_ends_where_it_should() -> None:
    graded = RimGradedAxis(1.0, 12, 1.3).lines()
    pressure = np.sqrt(np.maximum(1.0 - graded[:, None] ** 2 - graded**2, 0.0))
    traction = np.stack([0.6 * pressure, 0.0 * pressure, -pressure], axis=-1)
    edge = SubgridTraction.of_nodes(traction, (graded, graded)).edge()
    places = np.interp(edge, np.arange(float(len(graded))), graded)
    np.testing.assert_allclose(np.hypot(*places.T), 1.0, atol=0.01)


def test_the_finer_a_facing_bodys_elements_are_the_stiffer_are_the_others_alone() -> None:
    """Waves of coarse elements are long for those of a finer body, whose lattice reaches deeper than they do."""
    own, plain = Bricks(bodies.STEEL, (0.005, 1.3)), ((1.0, 0.0), (0.0, 1.0))
    lacking = [
        missing_displacement(own, (0.01, 0.01), Bricks(bodies.STEEL, (0.005 / finer, 1.3)), 2 * (0.01 / finer,), plain)
        for finer in (2, 3, 5)
    ]
    at_node = [float(one[6, 6, 2, 2]) for one in lacking]
    assert at_node[0] > at_node[1] > at_node[2]


@pytest.mark.parametrize("shear", [(1.0, 0.0), (0.0, 1.0)])
def test_elements_that_shrink_to_the_rim_are_corrected_as_those_at_the_edge_behind_the_shear(
    shear: tuple[float, float],
) -> None:
    """There, elements are short along the shear alone: taken for short ones both ways, tension was 1 % too high."""
    lines = RimGradedAxis(1.0, 6, 1.3).lines()
    count = len(lines) - 1
    mesh = bodies.brick((count, count, 2), (1.0, 1.0, 1.0))
    points = mesh.points.copy()
    for axis in (0, 1):
        points[:, axis] = np.interp(points[:, axis], np.unique(points[:, axis].round(9)), lines)
    mesh = HexMesh(points, mesh.cells, {**mesh.surfaces, "contact": mesh.surfaces["top"]})
    surface = SurfaceStress(mesh, bodies.patch_on(mesh), bodies.STEEL, (0.5, 1.0))
    pressure = np.maximum(1.01 - (surface.patch.grid() ** 2).sum(axis=1), 0.0)
    force = np.column_stack([0.3 * shear[0] * pressure, 0.3 * shear[1] * pressure, -pressure])
    short, long = np.diff(lines).min(), np.diff(lines)[count // 2]
    assert long > 1.2 * short
    found = surface.under(force).surface.spacing_mm
    assert found == pytest.approx([short if along else long for along in shear], rel=0.2)
    assert surface.under(force * [0.0, 0.0, 1.0]).surface.spacing_mm == pytest.approx([short, short], rel=0.15)


def test_the_stress_that_elements_of_a_half_plane_lack_is_gone_a_dozen_of_them_away() -> None:
    along = line_lattice_error(0.0036, 0.0036, 1.15, 0.3)[:, 0]
    middle = len(along) // 2
    assert np.abs(along[: middle - 11]).max() < 4e-4
    assert np.abs(along[middle + 12 :]).max() < 4e-4
