"""How far intervals of blind records would have to reach."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from studies.blind.intervals import distance
from wirewear.effects import all_effects

STIFFNESS = all_effects()["tangential_compliance"].parameters()["stiffness_N_per_mm"]


@given(st.floats(10.0, 1e4), st.floats(1.05, 10.0), st.floats(0.0, 3.0), st.sampled_from((1.0, -1.0)))
def test_a_truth_so_many_reaches_away_is_that_far_on_the_parameters_own_scale(
    value: float, factor: float, reaches: float, side: float
) -> None:
    """A stiffness is as uncertain upwards as downwards by a factor."""
    ends = value / factor, value * factor
    assert distance(STIFFNESS, value, ends, value * factor ** (side * reaches)) == pytest.approx(reaches, abs=1e-9)


def test_an_estimate_that_stands_at_the_end_of_its_range_knows_nothing_beyond() -> None:
    assert distance(STIFFNESS, 200.0, (100.0, 200.0), 200.0) == 0.0
    assert distance(STIFFNESS, 200.0, (100.0, 200.0), 201.0) == float("inf")
