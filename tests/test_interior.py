"""The whole body from its patch's forces: the same motion as the compliance, exact stresses, equilibrium."""

from dataclasses import replace

import numpy as np
import pytest

from geometry import HexMesh, WireMesh, build_wire
from solvers import condense
from solvers.interior import Interior
from solvers.strain import hydrostatic, integration_points, principal, tresca, turned, von_mises
from tests import bodies


@pytest.fixture(scope="module")
def wire() -> WireMesh:
    return bodies.wire(0.02)


def held(mesh: HexMesh) -> Interior:
    return Interior(mesh, bodies.STEEL, mesh.surface_nodes("grip"))


def test_the_patch_moves_as_its_compliance_says_under_forces_of_no_symmetry(wire: WireMesh) -> None:
    interior = held(wire.mesh)
    assert interior.planes == (0, 1)
    nodes = wire.patch.nodes.ravel()
    forces = np.random.default_rng(3).normal(size=(2, len(nodes), 3))
    moved = interior.displacements(nodes, forces)[:, nodes]
    compliance = condense(wire.mesh, wire.patch, bodies.STEEL).compliance
    expected = (compliance @ forces.reshape(2, -1).T).T.reshape(moved.shape)
    np.testing.assert_allclose(moved, expected, atol=1e-10 * np.abs(expected).max())


def test_forces_reach_the_grip_whole_with_their_moments(wire: WireMesh) -> None:
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


def test_an_elastic_grip_becomes_a_rigid_one_as_it_stiffens_and_keeps_the_symmetry(wire: WireMesh) -> None:
    mesh, nodes = wire.mesh, wire.patch.nodes.ravel()
    grip = mesh.surface_nodes("grip")
    forces = np.zeros((1, len(nodes), 3))
    forces[0, len(nodes) // 2] = [0.3, 0.2, -1.0]
    rigid = held(mesh).displacements(nodes, forces)
    offsets = []
    for stiffness in (1e6, 1e7):
        bedding = np.zeros(len(mesh.points))
        bedding[grip] = stiffness
        soft = Interior(mesh, bodies.STEEL, np.zeros(0, dtype=np.int64), bedding)
        assert soft.planes == (0, 1)
        offsets.append(float(np.abs(soft.displacements(nodes, forces) - rigid).max()))
    assert offsets[1] == pytest.approx(0.1 * offsets[0], rel=0.2)


def test_equivalent_stresses_of_plain_states() -> None:
    tension = np.array([100.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    shear = np.array([0.0, 0.0, 0.0, 100.0, 0.0, 0.0])
    assert (von_mises(tension), tresca(tension), hydrostatic(tension)) == pytest.approx((100.0, 100.0, 100.0 / 3.0))
    assert (von_mises(shear), tresca(shear)) == pytest.approx((100.0 * np.sqrt(3.0), 200.0))
    np.testing.assert_allclose(principal(shear), [100.0, 0.0, -100.0], atol=1e-9)
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(turned(tension, quarter), [0.0, 100.0, 0.0, 0.0, 0.0, 0.0], atol=1e-9)


def test_an_elastic_grip_gives_the_patch_its_compliance_too() -> None:
    wire = build_wire(
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
    interior = Interior(wire.mesh, bodies.STEEL, grip[:0], wire.bedding)
    everywhere = interior.displacements(nodes, forces)[0]
    expected = body.compliance @ forces.ravel()
    np.testing.assert_allclose(everywhere[nodes].ravel(), expected, atol=1e-10 * np.abs(expected).max())
    # What the springs push back is what the contact gives.
    pushed = (wire.bedding[:, None] * everywhere).sum(axis=0)
    np.testing.assert_allclose(pushed, forces[0].sum(axis=0), rtol=1e-8)
