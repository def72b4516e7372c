"""Stresses at a line contact's edge: what quadrilaterals lack of a half-plane's field, cusps of cylinder and flat."""

import numpy as np
import pytest
from numpy.typing import NDArray

from geometry import Flat, GradedAxis, PlanarGeometry, build_planar
from solvers.interior import Interior
from solvers.line_surface_stress import LineSurfaceStress, LoadedLine
from solvers.strain import integration_points
from solvers.subgrid_traction import SubgridTraction
from tests.bodies import STEEL
from wirewear import reference
from wirewear.verification import FULL, QUICK
from wirewear.verification.line_surface import line_surface_rows
from wirewear.verification.rows import Level

Array = NDArray[np.float64]

NU, FRICTION = 0.3, 0.62


def hertz(per_half_width: float, centre: float = 0.0) -> tuple[Array, Array]:
    """Nodes and their tractions of a line contact that slides towards +x, of unit half-width and pressure."""
    x = np.arange(-2.5, 2.5 + 1e-9, 1.0 / per_half_width)
    pressure = np.sqrt(np.maximum(1.0 - (x - centre) ** 2, 0.0))
    return x, np.stack([-FRICTION * pressure, 0.0 * pressure, -pressure], axis=-1)


def flat(half_width_mm: float, fine_mm: float) -> LineSurfaceStress:
    lines = GradedAxis(fine_mm, half_width_mm, fine_mm, half_width_mm)
    return LineSurfaceStress.of(build_planar(PlanarGeometry(Flat(), 20.0, 20.0, lines)), STEEL)


@pytest.mark.parametrize("per_half_width", [6.0, 12.0, 40.0])
@pytest.mark.parametrize("centre", [0.0, 0.03])
def test_between_nodes_hertzs_pressure_ends_at_its_edges_however_fine_the_mesh(
    per_half_width: float, centre: float
) -> None:
    x, traction = hertz(per_half_width, centre)
    edges = np.interp(SubgridTraction.of_nodes(traction[:, None]).edge()[:, 0], np.arange(float(len(x))), x)
    np.testing.assert_allclose(np.sort(edges) - centre, [-1.0, 1.0], atol=0.05 / per_half_width)


def test_one_line_stands_for_tractions_alike_across_it() -> None:
    _, traction = hertz(8.0)
    line = SubgridTraction.of_nodes(traction[:, None])
    wide = SubgridTraction.of_nodes(np.repeat(traction[:, None], 61, axis=1))
    np.testing.assert_allclose(line.square[:, 0], wide.square[:, 30], atol=1e-9)
    np.testing.assert_allclose(line.ratio[:, 0], wide.ratio[:, 30], atol=1e-9)


def test_what_quadrilaterals_lack_is_what_a_mesh_of_them_lacks() -> None:
    """A traction at one node: the mesh's stress near it is the half-plane's plus the lattice's error."""
    surface = flat(0.5, 0.02)
    nodes = surface.patch.nodes.ravel()
    middle = len(nodes) // 2
    points = integration_points(surface.mesh)
    held = Interior(surface.mesh, STEEL, surface.mesh.surface_nodes("grip"))
    for component in (0, 2):
        forces = np.zeros((1, len(nodes), 3))
        forces[0, middle - 1 : middle + 2, component] = np.array([1.0, 4.0, 1.0]) / 6.0 * surface.spacing_mm
        moved = held.displacements(nodes, forces)[0]
        found = points.at_nodes(points.stresses(STEEL, moved))[nodes]
        expected = surface.stencil[len(nodes) - 1 - middle : 2 * len(nodes) - 1 - middle, :, component]
        near = slice(middle - 8, middle + 9)
        # The last rows of elements beneath are those of a mesh that grows, not of an endless one.
        np.testing.assert_allclose(found[near], expected[near], atol=0.01)
        assert np.abs(found[near]).max() > 0.2


@pytest.mark.seconds
def test_the_half_planes_stress_by_these_tractions_is_mcewens() -> None:
    x, traction = hertz(12.0)
    mesh = flat(2.5, 1.0 / 12.0)
    loaded = LoadedLine(mesh, traction)
    edge = float(loaded.between.edge()[:, 0].min())
    places = np.append([edge], 30.0 + 12.0 * np.array([-0.5, 0.0, 0.7, 1.3]))
    found = np.array([loaded._exact(place) for place in places])
    exact = reference.line_stress(
        np.interp(places, np.arange(float(len(x))), x).clip(-1.0),
        np.zeros(len(places)),
        half_width_mm=1.0,
        peak_pressure_MPa=1.0,
        peak_shear_MPa=-FRICTION,
        poissons_ratio=NU,
    )
    # The body lies below, its normal points out: the closed form's z axis points in.
    np.testing.assert_allclose(found[:, :4], exact[:, :4], atol=0.03)
    np.testing.assert_allclose(found[:, 5], -exact[:, 5], atol=0.015)


@pytest.mark.slow
@pytest.mark.parametrize("level", [QUICK, FULL])
def test_the_tension_behind_a_sliding_and_a_slipping_cylinder_is_mcewens_and_cattaneos(level: Level) -> None:
    rows = line_surface_rows(level)
    assert len(rows) == 4
    assert [row for row in rows if not row.passed] == []
