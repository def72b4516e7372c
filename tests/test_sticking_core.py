"""A core that sticks for good while the annulus around it wears."""

from dataclasses import replace

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from solvers.contact.gaps import faced
from solvers.fretting import anew
from tests.bodies import crossed_wires
from tests.wear_jumps import INCREMENTS, RATES, at_the_end, jumped

STROKE_mm = 4.0e-4
NEXT_TO_NOTHING_mm = 1e-9


def test_bodies_pressed_anew_around_worn_scars_leave_no_friction_on_what_sticks() -> None:
    problem = crossed_wires(0.005, wear=RATES)
    worn = jumped(problem, at_the_end(problem, STROKE_mm), 2e4, stroke_mm=STROKE_mm).state
    assert worn.core.sum() > 4
    with threadpool_limits(limits=1, user_api="blas"):
        state = anew(problem, worn, NEXT_TO_NOTHING_mm, INCREMENTS)
    core = np.flatnonzero(worn.core)
    frames = faced(problem, state, core, state.drive, state.holder_x, state.holder_tilt).frames
    pressure, *friction = np.einsum("ikj,ij->ki", frames, state.traction[core])
    assert np.hypot(*friction).max() < 1e-3 * problem.friction * pressure.max()


@pytest.mark.slow
def test_wear_beside_a_core_does_not_open_it_where_the_nodes_of_both_bodies_do_not_meet() -> None:
    upper, lower = crossed_wires(0.005, wear=RATES).upper, crossed_wires(0.0047).lower
    problem = replace(crossed_wires(0.005, wear=RATES), upper=upper, lower=lower)
    fresh = at_the_end(problem, STROKE_mm)
    worn = jumped(problem, fresh, 2e4, stroke_mm=STROKE_mm).state
    core = np.flatnonzero(worn.core)
    gap = [
        faced(problem, replace(worn, wear=of.wear), core, worn.drive, worn.holder_x, worn.holder_tilt).gap
        for of in (fresh, worn)
    ]
    assert worn.wear.secondary_depth.max() > 1e-5
    np.testing.assert_allclose(gap[1], gap[0], atol=1e-3 * worn.wear.secondary_depth.max())
