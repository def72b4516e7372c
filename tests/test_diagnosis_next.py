"""A further measurement of the same rig updates a diagnosis."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.diagnosis_cases import nominal, record, states
from wirewear import RecordError
from wirewear.diagnosis.diagnose import judged, require_of_one_rig
from wirewear.diagnosis.infer.search import Search, search, updated
from wirewear.diagnosis.model.nominal import nominal_study
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.records import ExperimentRecord
from wirewear.views.diagnosis_values import Diagnosis

EFFECTS = {
    "none": {},
    "spring": {"tangential_compliance": {"stiffness_N_per_mm": 400.0}},
    "sensor": {"displacement_load_coupling": {"linear_um_per_N": 2.5, "quadratic_um_per_N2": 0.0}},
}


@cache
def searched(one: ExperimentRecord) -> Search:
    """The search on the states of the made-up wires."""
    return search(states(), nominal(one.tables.conditions.drive), reduce(one))


def diagnosis_of(first: ExperimentRecord, *further: ExperimentRecord) -> Diagnosis:
    """The answer to a record, updated by others, on the states of the made-up wires."""
    found = searched(first)
    for other in further:
        found = updated(found, states(), nominal(other.tables.conditions.drive), reduce(other))
    return judged(first, nominal_study(first), states(), reduce(first), found, further).diagnosis


@cache
def one_loop(effect: str, drive: str, seed: int, cycle: int) -> ExperimentRecord:
    """A record that says as little as one can."""
    return record(EFFECTS[effect], repeats=1, seed=seed, drive=drive, evolution=False, normal=False, cycles=(cycle,))


def test_a_stroke_held_by_an_encoder_tells_a_sensor_from_a_spring() -> None:
    alone = diagnosis_of(one_loop("sensor", "sensor", 1, 100))
    (group,) = alone.equivalent
    assert {"tangential_compliance", "displacement_load_coupling"} <= set(group)
    both = diagnosis_of(one_loop("sensor", "sensor", 1, 100), one_loop("sensor", "stroke", 2, 100))
    assert both.equivalent == ()
    assert both.causes[0].effect == "displacement_load_coupling"
    assert both.causes[0].probability > 0.95
    spring = diagnosis_of(one_loop("spring", "sensor", 1, 100), one_loop("spring", "stroke", 2, 100))
    assert spring.causes[0].effect == "tangential_compliance"
    assert not any("displacement_load_coupling" in members for members in spring.equivalent)


@pytest.mark.slow
def test_two_records_of_a_test_say_what_one_of_two_repeats_says() -> None:
    first, second = (record(EFFECTS["spring"], repeats=1, seed=seed, cycles=(100, 10_000)) for seed in (1, 2))
    loops = (*first.loops, *(replace(loop, repeat=2) for loop in second.loops))
    evolution = (*first.evolution, *(replace(one, repeat=2) for one in second.evolution))
    together = diagnosis_of(replace(first, loops=loops, evolution=evolution))
    apart = diagnosis_of(first, second)
    one, other = (answer.causes[0].parameters["stiffness_N_per_mm"] for answer in (together, apart))
    alone = diagnosis_of(first).causes[0].parameters["stiffness_N_per_mm"]
    widths = [np.diff(np.log(each.interval95))[0] for each in (one, other, alone)]
    assert other.value == pytest.approx(one.value, rel=0.03)
    assert widths[1] == pytest.approx(widths[0], rel=0.3)
    assert widths[1] < 0.85 * widths[2]
    assert apart.to_json()["updated_by"] == [second.name]


@pytest.mark.slow
def test_a_record_without_a_gap_stays_so_with_another_one() -> None:
    answer = diagnosis_of(one_loop("none", "sensor", 1, 100), one_loop("none", "stroke", 2, 1000))
    assert answer.verdict == "no_gap"


def test_a_gap_that_a_further_record_does_not_show_is_no_effect_of_the_rig() -> None:
    answer = diagnosis_of(one_loop("spring", "sensor", 1, 100), one_loop("none", "sensor", 2, 100))
    assert answer.verdict != "explained"


def test_the_same_loops_are_no_further_measurement() -> None:
    first = one_loop("none", "sensor", 1, 100)
    with pytest.raises(RecordError, match="is diagnosed alone"):
        require_of_one_rig(first, [first])
