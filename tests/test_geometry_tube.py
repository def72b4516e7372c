"""Tubes: wires with a bore."""

from math import log, pi

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from geometry import BodyMesh, GeometryError, GradedAxis, Layering, QuadMesh, WireGeometry, build_body
from geometry.sections import wire_section
from solvers.condensation import condense
from solvers.strain import stiffness_matrix
from tests.bodies import STEEL

AXIS = GradedAxis(0.02, 0.04, 0.03, 0.1)


def tube(bore_mm: float, *, gripped_at_ends: bool = False) -> WireGeometry:
    return WireGeometry(1.0, 2.2, AXIS, AXIS, 0.155, gripped_at_ends=gripped_at_ends, bore_mm=bore_mm)


def ring_compliance(outer_mm: float, inner_mm: float) -> float:
    """How much nearer two opposite unit line loads come on a ring's middle line, mm per N/mm, in plane strain.

    A curved bar's energy by bending, stretching and shear (Timoshenko, Strength of Materials II, 1956, section 16).
    """
    thick, middle = outer_mm - inner_mm, 0.5 * (outer_mm + inner_mm)
    offset = middle - thick / log(outer_mm / inner_mm)
    stretch = thick * STEEL.youngs_modulus_MPa / (1.0 - STEEL.poissons_ratio**2)
    shear = thick * STEEL.youngs_modulus_MPa / (2.0 + 2.0 * STEEL.poissons_ratio) / 1.2
    angle = np.linspace(0.0, pi, 2001)
    s, c, one = np.sin(angle), np.cos(angle), np.ones_like(angle)
    # By half of the load, and by the unknown horizontal force and moment at the crown, which does not turn or move.
    moment, normal, across = (
        np.array([-0.5 * middle * s, middle * (c - 1.0), one]),
        np.array([-0.5 * s, c, 0.0 * one]),
        np.array([0.5 * c, s, 0.0 * one]),
    )
    energy = (
        moment[:, None] * moment / (stretch * offset * middle)
        + (normal[:, None] * normal - (moment[:, None] * normal + normal[:, None] * moment) / middle) / stretch
        + across[:, None] * across / shear
    )
    work = middle * np.trapezoid(energy, angle)
    return float(2.0 * (work[0, 0] - work[0, 1:] @ np.linalg.solve(work[1:, 1:], work[1:, 0])))


@pytest.mark.parametrize("bore_mm", [0.88, 0.94])
def test_a_ring_gives_way_as_a_curved_bar_does_and_better_on_finer_meshes(bore_mm: float) -> None:
    exact = ring_compliance(0.5, 0.5 * bore_mm)
    usual, fine = (_ring(bore_mm, coarse_mm) / exact - 1.0 for coarse_mm in (0.155, 0.05 * (1.0 - bore_mm)))
    assert -0.06 < usual < fine < 0.0
    assert abs(fine) < 0.01


def _ring(bore_mm: float, coarse_mm: float) -> float:
    """How much nearer the crown and the back of a meshed section come, in the middle of the wall."""
    size = min(coarse_mm, (1.0 - bore_mm) / 6.0)
    lines = GradedAxis(size, 0.04, size, 0.1).half_lines()
    points, quads = wire_section(0.5, lines, coarse_mm, Layering(), None, 0.5 * bore_mm)
    stiffness = stiffness_matrix(QuadMesh(points, quads, {}), STEEL).tocsc()
    y, z = points.T
    upper, lower = (np.flatnonzero((y == 0.0) & side) for side in (z > -0.5, z < -0.5))
    held = np.zeros((len(points), 3), dtype=bool)
    held[:, 1] = True
    held[y == 0.0, 0] = True
    held[lower[z[lower].argmin()], 2] = True
    force, moved = np.zeros(held.size), np.zeros(held.size)
    force[3 * upper[z[upper].argmax()] + 2] = -0.5
    free = np.flatnonzero(~held.ravel())
    moved[free] = spsolve(stiffness[free][:, free], force[free])
    middle = 0.25 * (1.0 + bore_mm)
    at = (
        np.interp(level, *(np.sort(z[line]), moved[3 * line[z[line].argsort()] + 2]))
        for line, level in ((upper, middle - 0.5), (lower, -middle - 0.5))
    )
    return float(-np.subtract(*at))


def _compliances(geometry: WireGeometry) -> np.ndarray:
    """Mean displacement by a uniform traction along, across and into the body."""
    meshed = build_body(geometry)
    compliance = condense(meshed.mesh, meshed.patch, STEEL).compliance
    share = meshed.patch.node_areas() / meshed.patch.node_areas().sum()
    return np.array([share @ compliance[k::3, k::3] @ share for k in range(3)])


def test_a_tube_of_a_narrow_bore_is_as_stiff_as_a_wire_and_of_a_wide_one_softer() -> None:
    wire, narrow, wide = (_compliances(tube(bore_mm)) for bore_mm in (0.0, 0.06, 0.7))
    assert narrow == pytest.approx(wire, rel=0.01)
    assert np.all(wide > 1.3 * wire)


@pytest.fixture(scope="module", params=[0.1, 0.5, 0.94])
def meshed(request: pytest.FixtureRequest) -> BodyMesh:
    return build_body(tube(request.param))


def test_a_tube_is_sound_symmetric_and_held_on_the_outside_of_its_back(meshed: BodyMesh) -> None:
    mesh, geometry = meshed.mesh, meshed.geometry
    assert isinstance(geometry, WireGeometry)
    full = 0.25 * pi * (1.0 - geometry.bore_mm**2) * 2.2
    assert mesh.volume_mm3() == pytest.approx(full, rel=0.015)
    assert meshed.smallest_scaled_jacobian > 0.3
    for axis in (0, 1):
        image = mesh.points.copy()
        image[:, axis] *= -1.0
        assert np.array_equal(image[np.lexsort(image.T)], mesh.points[np.lexsort(mesh.points.T)])
    radius = np.hypot(mesh.points[:, 1], mesh.points[:, 2] + 0.5)
    assert radius.min() == pytest.approx(0.5 * geometry.bore_mm)
    assert radius[mesh.surface_nodes("grip")] == pytest.approx(0.5)
    assert mesh.points[mesh.surface_nodes("grip"), 2].max() < -0.5


def test_a_tube_held_at_its_ends_is_held_all_over_them_and_nowhere_else() -> None:
    mesh = build_body(tube(0.5, gripped_at_ends=True)).mesh
    ends = np.abs(mesh.points[:, 0]) > 1.1 - 1e-12
    assert np.array_equal(mesh.surface_nodes("grip"), np.flatnonzero(ends))


def test_a_bore_as_wide_as_the_tube_is_refused() -> None:
    with pytest.raises(GeometryError, match="bore must be narrower"):
        tube(1.0)
