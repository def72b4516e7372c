"""Bodies from files: what is read of them, and how they give way under their patch."""

from pathlib import Path

import numpy as np
import pytest

from geometry import BlockGeometry, Elastic, GradedAxis, build_body
from geometry.arrays import Array
from geometry.embedded import EmbeddedGeometry, as_grid
from geometry.mesh_files import digest_of
from geometry.own_surface import MeshSource, own_surface
from solvers.elasticity.condensation import condense
from solvers.elasticity.embedding import Joined, condense_meshed
from solvers.stress.interior import EmbeddedInterior
from tests.bodies import ball_of_tetrahedra, brick

STEEL = Elastic(210e3, 0.3)
AXIS = GradedAxis(0.05, 0.1, 0.1, 0.2)
CURVED = 0.2
BLOCK = BlockGeometry(CURVED, CURVED, 1.5, 1.5, 1.5, AXIS, AXIS, 0.5)


@pytest.fixture(scope="module", params=[".msh", ".inp"])
def written(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> MeshSource:
    """A built-in block with a ball's face, in a file."""
    file = tmp_path_factory.mktemp("own") / f"ball{request.param}"
    build_body(BLOCK).mesh.write(file)
    return MeshSource(str(file), digest_of(str(file)), 1.0, "contact", "grip")


def test_a_built_in_body_that_is_read_back_is_the_same_body(written: MeshSource) -> None:
    own, fresh = own_surface(written), build_body(BLOCK)
    np.testing.assert_allclose(own.curvatures_per_mm, CURVED, rtol=1e-9)
    grid = as_grid(written, None)
    assert grid is not None
    np.testing.assert_allclose(grid.layers, BLOCK.layers, rtol=1e-9)
    read, built = condense_meshed(build_body(grid), STEEL), condense(fresh.mesh, fresh.patch, STEEL)
    np.testing.assert_allclose(read.compliance, built.compliance, atol=1e-9 * built.compliance.max())
    places = built.patch.grid()
    np.testing.assert_allclose(read.patch.height(places), built.patch.height(places), atol=1e-12)


def under_hertz(patch: object, compliance: np.ndarray) -> np.ndarray:
    """Displacement of the middle along x and z by Hertz' pressure over a radius of 0.15 mm, in each direction."""
    where = patch.grid()  # type: ignore[attr-defined]
    force = np.sqrt(np.maximum(1.0 - (where**2).sum(axis=1) / 0.15**2, 0.0)) * patch.node_areas()  # type: ignore[attr-defined]
    middle = len(where) // 2
    return np.array([compliance[3 * middle + k, k::3] @ force for k in (0, 2)])


@pytest.mark.seconds
@pytest.mark.first_case
def test_a_block_embedded_in_a_files_elements_gives_way_as_one_fine_mesh(written: MeshSource) -> None:
    size = (0.6, 0.6, 0.6)
    embedded = build_body(EmbeddedGeometry(CURVED, CURVED, *size, AXIS, AXIS, 0.15, source=written))
    fine = build_body(BLOCK.with_layering(BLOCK.layering.deeper(2.0)))
    built = condense(fine.mesh, fine.patch, STEEL)
    found = condense_meshed(embedded, STEEL)
    np.testing.assert_allclose(
        under_hertz(found.patch, found.compliance), under_hertz(built.patch, built.compliance), rtol=0.01
    )


@pytest.mark.slow
@pytest.mark.parametrize(("order", "element_mm"), [(1, 0.15), (2, 0.25)])
def test_a_ball_of_tetrahedra_gives_way_as_the_programs_own(order: int, element_mm: float, tmp_path: Path) -> None:
    ball_of_tetrahedra(tmp_path / "ball.msh", 1.0 / CURVED, 1.5, 1.5, element_mm, order)
    file = str(tmp_path / "ball.msh")
    source = MeshSource(file, digest_of(file), 1.0, "contact", "grip")
    found = condense_meshed(
        build_body(EmbeddedGeometry(CURVED, CURVED, 0.6, 0.6, 0.6, AXIS, AXIS, 0.15, source=source)), STEEL
    )
    fine = build_body(BLOCK.with_layering(BLOCK.layering.deeper(2.0)))
    built = condense(fine.mesh, fine.patch, STEEL)
    np.testing.assert_allclose(
        under_hertz(found.patch, found.compliance), under_hertz(built.patch, built.compliance), rtol=0.01
    )


@pytest.mark.seconds
def test_inside_an_embedded_block_of_two_materials_the_patch_moves_as_its_compliance_says(tmp_path: Path) -> None:
    mesh = build_body(BLOCK).mesh
    mesh.write(file := tmp_path / "ball.inp")
    deep = np.flatnonzero(mesh.points[mesh.cells].mean(axis=1)[:, 2] < -0.2) + 1
    file.write_text(file.read_text() + "*ELSET, ELSET=core\n" + "\n".join(map(str, deep)))
    parts = (("core", 70e3, 0.33),)
    source = MeshSource(str(file), digest_of(str(file)), 1.0, "contact", "grip", parts=parts)
    axis = GradedAxis(0.1, 0.1, 0.1, 0.2)
    meshed = build_body(EmbeddedGeometry(CURVED, CURVED, 0.5, 0.5, 0.5, axis, axis, 0.25, source=source))
    assert set(meshed.host.block_part.ravel()) == {0, 1}  # type: ignore[union-attr]
    nodes = meshed.patch.nodes.ravel()
    force = np.random.default_rng(1).normal(size=(1, len(nodes), 3))
    interior = EmbeddedInterior(meshed.mesh, STEEL, nodes[:0], joined=Joined.of(meshed, STEEL))
    moved = interior.displacements(nodes, force)[0, nodes].ravel()
    np.testing.assert_allclose(
        moved, condense_meshed(meshed, STEEL).compliance @ force.ravel(), atol=1e-7 * abs(moved).max()
    )


def layered(wave_per_mm: float, thickness_mm: float, layer: Elastic, core: Elastic) -> float:
    """Deflection in mm of a layer on a deep core under a pressure of 1 MPa that goes as J0(wave r) on it.

    Love's function is J0 times z^n exp(±wave z) (Timoshenko and Goodier, Theory of Elasticity, section 143).
    """

    def moved(body: Elastic, z: float, signs: tuple[int, ...]) -> Array:
        """Rows: deflection, radial displacement, and stresses normal and along; columns: parts of the function."""
        shear, nu, w2 = body.shear_modulus_MPa, body.poissons_ratio, wave_per_mm**2
        columns = []
        for k in (sign * wave_per_mm for sign in signs):
            for f in ([k**n for n in range(4)], [z, 1.0 + k * z, 2.0 * k + k**2 * z, 3.0 * k**2 + k**3 * z]):
                down = ((1.0 - 2.0 * nu) * f[2] - 2.0 * (1.0 - nu) * w2 * f[0]) / (2.0 * shear)
                stresses = (1.0 - nu) * f[3] - (2.0 - nu) * w2 * f[1], nu * f[2] + (1.0 - nu) * w2 * f[0]
                columns.append(np.exp(k * z) * np.array([down, f[1] / (2.0 * shear), *stresses]))
        return np.array(columns).T

    faded = np.array([1.0, 1.0, *2 * [np.exp(-wave_per_mm * thickness_mm)]])  # What grows downwards is scaled.
    top, below = moved(layer, 0.0, (-1, 1)) * faded, moved(layer, thickness_mm, (-1, 1)) * faded
    matrix = np.block([[top[2:], np.zeros((2, 2))], [below, -moved(core, thickness_mm, (-1,))]])
    return float(top[0] @ np.linalg.solve(matrix, [-1.0, *5 * [0.0]])[:4])


@pytest.mark.slow
def test_a_layer_on_a_core_of_another_material_gives_way_as_its_closed_form_says(tmp_path: Path) -> None:
    """Steel of 0.2 mm on aluminium under Hertz' pressure of 1 MPa, less aluminium alone: Hankel's transform."""
    radius, thick, core = 0.15, 0.2, Elastic(70e3, 0.33)
    mesh = brick((15, 15, 15), (3.0, 3.0, 3.0))
    mesh.write(file := tmp_path / "block.inp")
    deep = np.flatnonzero(mesh.points[mesh.cells].mean(axis=1)[:, 2] < -thick) + 1
    file.write_text(file.read_text() + "*ELSET, ELSET=core\n" + "\n".join(map(str, deep)))
    axis, moved = GradedAxis(0.025, 0.2, 0.05, 0.25), []
    for parts, material in (((("core", core.youngs_modulus_MPa, core.poissons_ratio),), STEEL), ((), core)):
        source = MeshSource(str(file), digest_of(str(file)), 1.0, "top", "grip", parts=parts)
        meshed = build_body(EmbeddedGeometry(0.0, 0.0, 0.6, 0.6, 0.6, axis, axis, 0.15, source=source))
        moved.append(condense_meshed(meshed, material))
    where = moved[0].patch.grid()
    force = np.sqrt(np.maximum(1.0 - (where**2).sum(axis=1) / radius**2, 0.0)) * moved[0].patch.node_areas()
    force *= 2.0 / 3.0 * np.pi * radius**2 / force.sum()
    middle = 3 * (len(where) // 2) + 2
    found = [float(body.compliance[middle, 2::3] @ force) for body in moved]
    wave = np.linspace(1e-3, 400.0, 8000)
    load = radius**2 * (np.sin(wave * radius) / (wave * radius) ** 3 - np.cos(wave * radius) / (wave * radius) ** 2)
    alone = 2.0 * (1.0 - core.poissons_ratio**2) / core.youngs_modulus_MPa / wave
    own = np.array([layered(one, thick, STEEL, core) for one in wave])
    assert found[0] - found[1] == pytest.approx(np.trapezoid(load * wave * (own - alone), wave), rel=0.015)
