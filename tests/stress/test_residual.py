"""Residual stress of first cycles: where it stands, what wear leaves of it, what it does to lives, and who has any."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from geometry.arrays import Array
from solvers.elasticity.linear_elasticity import integration_points, von_mises
from solvers.stress.interior import Interior
from tests.bodies import STEEL, brick, wire
from tests.simulation.test_yielding_runs import wires
from tests.stress.fatigue_data import OWN, STRENGTH, B
from tests.stress.interior_runs import CYCLE, run_with_forces
from wirewear.results import RunResult
from wirewear.results.values import YIELD_STRESS
from wirewear.simulation.near_zone import near_zone_of
from wirewear.stress import body_grid, body_states
from wirewear.stress.bodies import BodyState
from wirewear.stress.criteria import criterion_of
from wirewear.stress.life import wear_state
from wirewear.stress.residual import Residual, residual_stress
from wirewear.test.life import LifeTable

pytestmark = pytest.mark.seconds
YIELD_MPa = 1400.0


def run_of(plasticity: str = "near zone", **stated: Any) -> RunResult:
    """Forces on coarse wires, as if of a study whose wires yield."""
    study = wires(wires={"yield_stress_MPa": YIELD_MPa} | stated, contact={"plasticity": plasticity, "friction": 0.0})
    near = near_zone_of(study)
    strain = () if near is None else near.strains("moving", "fixed")
    return replace(run_with_forces(), study=study.resolved(), plastic_strain=strain)


def states(result: RunResult, *, worn: bool = False) -> tuple[BodyState, ...]:
    return body_states(result, "fixed", CYCLE, worn=worn)


def test_stresses_inside_a_wire_have_the_residual_stress_that_is_left_beneath_it() -> None:
    with_it, without = (states(run_of(name))[0] for name in ("near zone", "limited pressure"))
    left, places = with_it.stress_at_points - without.stress_at_points, with_it.body.points.positions
    # Metal that was squeezed aside is pressed back.
    assert left[..., :2].min() < -0.1 * YIELD_MPa
    assert np.abs(left[np.abs(places[..., 2]) > 0.08]).max() < 0.01 * YIELD_MPa
    assert von_mises(left).max() < YIELD_MPa
    # Nothing but its grip acts on the wire: other nodes bear no force by that stress.
    force = with_it.body.points.internal_forces(left)
    force[with_it.body.mesh.surface_nodes("grip")] = 0.0
    assert np.abs(force).max() < 1e-5 * np.abs(with_it.body.points.internal_forces(with_it.stress_at_points)).max()
    assert "residual_stress_MPa" in body_grid(with_it).point_data
    assert "residual_stress_MPa" not in body_grid(without).point_data


def test_friction_on_metal_is_no_more_than_it_bears_in_shear() -> None:
    run = run_with_forces()

    def parts(result: RunResult) -> tuple[Array, Array]:
        """Pressure and shear at the nodes at all positions of the cycle, MPa."""
        found = [(one.traction_MPa, one.surface_normal) for one in states(result)]
        pressing = np.array([np.einsum("nk,nk->n", *one) for one in found])
        shear = [t - p[:, None] * n for (t, n), p in zip(found, pressing, strict=True)]
        return pressing, np.linalg.norm(shear, axis=-1)

    pressing, shear = parts(run)
    borne = 0.5 * float(shear.max())
    limited = parts(replace(run, settings={**run.settings, YIELD_STRESS: np.sqrt(3.0) * borne}))
    assert limited[0] == pytest.approx(pressing, rel=0.03, abs=1e-2 * borne)
    assert limited[1] == pytest.approx(np.minimum(shear, borne), rel=0.03, abs=1e-2 * borne)


def strained_layer(left_mm: float) -> Array:
    """Stresses (k, 6) on the middle line of a plate whose upper 0.04 mm of 0.2 mm were strained by 0.001 along x and y,
    once all but `left_mm` of them have worn away; from the surface down.
    """
    layers = round((0.16 + left_mm) / 0.02)
    mesh = brick((8, 8, layers), (3.2, 3.2, 0.02 * layers))
    points = integration_points(mesh)
    strain = np.zeros((*points.volumes.shape, 6))
    strain[points.positions[..., 2] > -left_mm] = 1e-3 * np.array([1.0, 1.0, -2.0, 0.0, 0.0, 0.0])
    found = residual_stress(strain, points, Interior(mesh, STEEL, mesh.surface_nodes("grip")), STEEL).at_points
    middle = np.abs(points.positions[..., :2]).max(axis=-1) < 0.15
    means = [found[middle & (points.positions[..., 2] // 0.02 == -k)].mean(axis=0) for k in range(1, layers + 1)]
    return np.array(means)


def test_a_strained_layer_on_a_plate_is_stressed_as_in_closed_form_until_it_has_worn_away() -> None:
    """A held thick plate lets a layer not spread: σ = -E ε / (1 - ν) in its plane, none across it."""
    expected = -STEEL.youngs_modulus_MPa * 1e-3 / (1.0 - STEEL.poissons_ratio)
    for left_mm in (0.04, 0.02):
        stress, strained = strained_layer(left_mm), round(left_mm / 0.02)
        assert stress[:strained, :2] == pytest.approx(np.full((strained, 2), expected), rel=0.02)
        assert np.abs(stress[:, 2]).max() < 0.01 * abs(expected)
        assert np.abs(stress[strained:, :2]).max() < 0.03 * abs(expected)
    assert not strained_layer(0.0).any()


@pytest.mark.parametrize("residual_MPa", [-300.0, 0.0, 200.0])
def test_uniform_residual_stress_is_the_mean_stress_of_lives(residual_MPa: float) -> None:
    """A wire pulled to and fro by 400 MPa: σ_a / (1 - σ_m / σ_f') on Basquin's line, in all its depths."""
    result = run_of("none")
    (forces,) = (one for one in result.contact_forces if one.body == "fixed")
    bulk = np.zeros((len(forces.phase), 3))
    bulk[:, 0] = 400.0 * np.cos(2.0 * np.pi * forces.phase)
    unloaded = replace(forces, force_N=1e-9 * forces.force_N, bulk_stress_MPa=bulk)
    cycle = states(replace(result, contact_forces=(unloaded,)))
    uniform = np.zeros((*cycle[0].body.points.volumes.shape, 6))
    uniform[..., :2] = residual_MPa
    residual = Residual(cycle[0].body.points, uniform)
    table = LifeTable(criterion="stress-life", **OWN)
    depths = 2e-3 * np.arange(11.0)
    found = wear_state(
        [replace(one, residual=residual) for one in cycle],
        criterion_of(table, STEEL), table, depths, np.zeros(wire(0.02).patch.shape),
    )  # fmt: skip
    expected = 0.5 * (400.0 / (1.0 - residual_MPa / STRENGTH) / STRENGTH) ** (1.0 / B)
    assert 10.0**-found.share == pytest.approx(np.full(found.share.shape, expected), rel=0.05)


@pytest.mark.parametrize(
    ("stated", "bodies"),
    [
        pytest.param({}, 2, id="both yield"),
        pytest.param({"moving": {"yield_stress_MPa": 700.0}}, 1, id="the softer one yields", marks=pytest.mark.slow),
        pytest.param({"yield_stress_MPa": 5000.0}, 0, id="load below first yield"),
    ],
)
def test_only_bodies_that_yield_have_residual_stress(stated: dict[str, Any], bodies: int) -> None:
    result = run_of(**stated)
    found = [body_states(result, body, CYCLE, [0], worn=False)[0].residual for body in ("fixed", "moving")]
    assert sum(one is not None for one in found) == bodies
