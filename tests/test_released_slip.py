"""Slip beside a sticking core as friction there fades: what a jump foresees against a cycle traced after it."""

import pytest
from threadpoolctl import threadpool_limits

from solvers import Symmetry, closed_trace, symmetry_of
from tests.bodies import crossed_wires
from tests.wear_jumps import INCREMENTS, RATES, at_the_end, jumped

MESH_mm = 0.005
#: By the rig's stiffness, 0 where it is rigid; some two thirds of the fresh contact's radius stick.
STROKES_mm = {0.0: 4.0e-4, 20.0: 0.045}
CYCLES = 5000.0


@pytest.mark.parametrize("rig_N_per_mm", STROKES_mm)
@pytest.mark.parametrize("folded", [True, False])
def test_friction_work_after_a_jump_is_that_of_the_cycle_on_the_worn_surfaces(
    rig_N_per_mm: float, folded: bool
) -> None:
    stroke = STROKES_mm[rig_N_per_mm]
    problem = crossed_wires(MESH_mm, long_patch=False, rig_N_per_mm=rig_N_per_mm or None, wear=RATES)
    symmetry = symmetry_of(problem) if folded else Symmetry()
    start = at_the_end(problem, stroke)
    jump = jumped(problem, start, CYCLES, symmetry=symmetry, stroke_mm=stroke)
    works = []
    with threadpool_limits(limits=1, user_api="blas"):
        for state in (start, jump.state):
            _, trace = closed_trace(problem, state, stroke, INCREMENTS, Symmetry())
            works.append(trace.friction_work)
    assert abs(works[1] / works[0] - 1.0) > 0.15
    assert jump.friction_work == pytest.approx(works[1], abs=0.3 * abs(works[1] - works[0]))
