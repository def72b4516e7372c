"""Residual stress of first loading: where it stands, what it is in balance with, and which bodies have any."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from solvers.elasticity.strain import von_mises
from tests.simulation.test_yielding_runs import wires
from tests.stress.interior_runs import CYCLE, run_with_forces
from wirewear.results import RunResult
from wirewear.stress import body_grid, body_states
from wirewear.stress.residual import residual_of

pytestmark = pytest.mark.seconds
YIELD_MPa = 1400.0


def run_of(plasticity: str = "near zone", **stated: Any) -> RunResult:
    """Forces on coarse wires, as if of a study whose wires yield."""
    contact = {"plasticity": plasticity, "friction": 0.0}
    study = wires(wires={"yield_stress_MPa": YIELD_MPa} | stated, contact=contact)
    return replace(run_with_forces(), study=study.resolved())


def test_stresses_inside_a_wire_have_the_residual_stress_that_is_left_beneath_it() -> None:
    (with_it,), (without,) = (
        body_states(run_of(name), "fixed", CYCLE, [0], worn=False) for name in ("near zone", "limited pressure")
    )
    left, places = with_it.stress_at_points - without.stress_at_points, with_it.body.points.positions
    # Metal that was squeezed aside is pressed back.
    assert left[..., :2].min() < -0.1 * YIELD_MPa
    assert np.abs(left[np.abs(places[..., 2]) > 0.08]).max() < 0.01 * YIELD_MPa
    assert von_mises(left).max() < YIELD_MPa
    assert "residual_stress_MPa" in body_grid(with_it).point_data
    assert "residual_stress_MPa" not in body_grid(without).point_data


def test_residual_stress_of_pressing_is_in_balance_and_alike_in_both_directions() -> None:
    result = run_of()
    residual = residual_of(result, result.forces(CYCLE, "fixed"))
    assert residual is not None
    # Thickness of layers of which each is a tenth thicker than the one above.
    middle, sizes = residual.stress.shape[1] // 2, 1.1 ** np.arange(len(residual.grid.depths_mm))
    section = residual.stress[:, middle, :, 0].sum(axis=1)
    across = np.abs(residual.stress[:, middle, :, 0]).sum(axis=1)
    # The balance of what is beyond the grid goes with one over its size.
    assert abs(section @ sizes) < 0.2 * (across @ sizes)
    assert residual.stress[:, middle, middle, 0] == pytest.approx(residual.stress[:, middle, middle, 1], abs=40.0)
    assert np.abs(residual.stress[0, :, :, 2]).max() < 0.05 * YIELD_MPa


@pytest.mark.parametrize(
    ("stated", "bodies"),
    [({}, 2), ({"moving": {"yield_stress_MPa": 700.0}}, 1), ({"yield_stress_MPa": 5000.0}, 0)],
    ids=["both yield", "the softer one yields", "load below first yield"],
)
def test_only_bodies_that_yield_have_residual_stress(stated: dict[str, Any], bodies: int) -> None:
    result = run_of(**stated)
    assert sum(residual_of(result, result.forces(CYCLE, body)) is not None for body in ("fixed", "moving")) == bodies
