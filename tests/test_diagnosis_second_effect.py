"""A second effect beside one that leaves no more than is expected."""

import pytest

from tests.diagnosis_cases import nominal, record, states
from wirewear.diagnosis.infer.gate import remainder_of
from wirewear.diagnosis.infer.search import search
from wirewear.diagnosis.observe.reduction import reduce

#: A lean of the holder, and a force cell that reads 1.6 % of the load: 0.03 N of 1.2 N.
LEAN = {"stiffness_N_mm_per_rad": 30000.0, "arm_mm": 10.0}
CROSSTALK = 0.016


@pytest.mark.slow
def test_a_second_effect_is_found_even_where_the_first_leaves_no_more_than_is_expected() -> None:
    both = {"rotational_compliance": LEAN, "force_crosstalk": {"coefficient": CROSSTALK}}
    found = search(states(), nominal("sensor"), reduce(record(both, repeats=1, normal=False, evolution=False)))
    first = max(found.singles, key=lambda one: one.merit)
    left = remainder_of(found.problem, first)
    assert left.misfit < 0.9
    assert left.block_p_value > 0.01
    assert found.best.names == ("tangential_compliance", "force_crosstalk")


@pytest.mark.slow
def test_no_second_effect_is_named_where_there_is_one() -> None:
    lean = record({"rotational_compliance": LEAN}, repeats=1, normal=False, evolution=False)
    assert not search(states(), nominal("sensor"), reduce(lean)).pairs
