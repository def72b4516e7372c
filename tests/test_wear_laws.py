"""Archard's law beside the energy law, the explicit update beside the cycle jump, coefficients that vary."""

from dataclasses import replace

import numpy as np
import pytest

from solvers.contact import ContactProblem
from solvers.contact_state import ContactState
from solvers.fretting import run_cycle
from tests.bodies import FRICTION, crossed_wires
from tests.studies import MINIMAL
from tests.wear_jumps import INCREMENTS, STROKE_mm, at_the_end, jumped, wires, worn
from wirewear import parse_study

MESH_mm = 0.010
RATES = (1.5e-8, 1.5e-8)
WORN = MINIMAL + "[wear]\n"


@pytest.fixture(scope="module")
def energy_law() -> ContactProblem:
    return crossed_wires(MESH_mm, long_patch=True, wear=RATES)


def depth_error(one: ContactState, other: ContactState) -> float:
    return max(
        float(np.abs(a - b).max() / b.max())
        for a, b in (
            (one.wear.primary_depth, other.wear.primary_depth),
            (one.wear.secondary_depth, other.wear.secondary_depth),
        )
    )


def test_with_constant_friction_archard_is_the_energy_law_with_its_coefficient_times_friction(
    energy_law: ContactProblem,
) -> None:
    archard = replace(energy_law, wear=replace(energy_law.wear.scaled(FRICTION), law="archard"))
    one, other = worn(archard, 20.0), worn(energy_law, 20.0)
    assert depth_error(one, other) < 1e-3
    assert one.wear.energy_mJ == pytest.approx(other.wear.energy_mJ, rel=1e-4)
    assert one.wear.primary_volume_mm3 == pytest.approx(other.wear.primary_volume_mm3, rel=1e-4)


def test_without_friction_archard_wears_and_the_energy_law_does_not(energy_law: ContactProblem) -> None:
    slippery = replace(energy_law, friction=0.0)
    archard = replace(slippery, wear=replace(energy_law.wear, law="archard"))
    assert not worn(slippery, 20.0).wear.primary_depth.any()
    state = worn(archard, 20.0)
    areas = archard.primary.patch.node_areas()
    assert state.wear.energy_mJ == 0.0
    assert float(areas @ state.wear.primary_depth.ravel()) == pytest.approx(state.wear.primary_volume_mm3, rel=1e-12)
    travelled = archard.holder.normal_load_N * 4.0 * STROKE_mm * 20.0
    assert state.wear.primary_volume_mm3 == pytest.approx(RATES[0] * travelled, rel=5e-3)


def test_surfaces_that_recede_after_each_increment_and_a_cycle_jump_agree_where_the_former_is_stable() -> None:
    problem = wires()
    start = at_the_end(problem)
    explicit = start
    for _ in range(3):
        explicit, _ = run_cycle(problem, explicit, STROKE_mm, 2 * INCREMENTS, 10.0)
    jump = jumped(problem, start, 30.0).state
    assert depth_error(explicit, jump) < 0.03
    assert explicit.wear.energy_mJ == pytest.approx(jump.wear.energy_mJ, rel=0.01)


def test_a_varying_coefficient_is_joined_by_straight_lines_and_constant_beyond() -> None:
    text = WORN + 'archard_wear_coefficient_mm3_per_N_m = 2e-5\nvariation = "cycles"\n'
    wear = parse_study(text + "variation_points = [[0, 2.0], [100, 1.0], [300, 0.5]]", "s.toml").wear
    assert wear is not None
    assert [wear.factor(cycles, 0.0) for cycles in (0, 50, 100, 200, 1e4)] == pytest.approx([2.0, 1.5, 1.0, 0.75, 0.5])
