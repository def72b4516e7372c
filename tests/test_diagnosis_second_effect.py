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


@pytest.mark.slow
@pytest.mark.parametrize(("likely", "named"), [(4, ("free_play", "normal_load_drift")), (0, ("free_play",))])
def test_what_explains_much_alone_is_fitted_beside_the_first_though_nothing_promises_it_there(
    likely: int, named: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    both = {"free_play": {"gap_um": 3.0}, "normal_load_drift": {"fraction_per_100k_cycles": -0.2}}
    # As if the first, bent to do for both, hid the second: no promise beside it counts.
    monkeypatch.setattr("wirewear.diagnosis.infer.search._SECONDS", 0)
    monkeypatch.setattr("wirewear.diagnosis.infer.search._LIKELY", likely)
    found = search(states(), nominal("sensor"), reduce(record(both, repeats=1, normal=False, evolution=False)))
    assert found.best.names == named
