"""Stresses at a contact's edge: tractions between nodes, what elements lack of a half-space's field, cusps of wires."""

import numpy as np
import pytest
from numpy.typing import NDArray

from geometry import HexMesh
from solvers.subgrid_traction import SubgridTraction
from solvers.surface_stress import LoadedSurface, SurfaceStress, half_space_stress
from tests import bodies
from wirewear import reference
from wirewear.verification import QUICK
from wirewear.verification.surface import surface_rows

Array = NDArray[np.float64]

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


@pytest.mark.seconds
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


@pytest.mark.slow
def test_the_tension_behind_sliding_and_slipping_wires_is_hamiltons_and_cattaneos() -> None:
    rows = surface_rows(QUICK)
    assert len(rows) == 4
    assert [row for row in rows if not row.passed] == []
