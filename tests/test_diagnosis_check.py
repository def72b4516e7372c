"""The judgement of diagnoses whose truth is known."""

from dataclasses import replace
from functools import cache

import pytest

from studies.diagnosis.check import Case, Outcome, outcome_table, summary
from tests.diagnosis_cases import diagnosed, record
from wirewear.diagnosis import Diagnosis

# All judge one diagnosis, which takes seconds.
pytestmark = pytest.mark.slow


@cache
def of_compliance() -> tuple[Diagnosis, Case]:
    one = record({"tangential_compliance": {"stiffness_N_per_mm": 300.0}}, repeats=1, evolution=False)
    return diagnosed(one).diagnosis, Case("one", one, ("tangential_compliance",))


def outcome(truth: tuple[str, ...], **changes: object) -> Outcome:
    diagnosis, case = of_compliance()
    return Outcome(replace(case, truth=truth), replace(diagnosis, **changes))  # type: ignore[arg-type]


def test_any_member_of_the_class_is_right() -> None:
    assert outcome(("tangential_compliance",)).judgement == "right class"
    assert outcome(("rotational_compliance",)).judgement == "right class"
    assert outcome(("free_play",)).judgement == "wrong class"


def test_a_gap_without_an_effect_is_a_false_alarm() -> None:
    assert outcome(()).judgement == "false alarm"
    assert outcome((), verdict="no_gap").judgement == "right"


def test_an_effect_that_was_declared_unseen_is_counted_apart() -> None:
    assert outcome(("plasticity",), verdict="no_gap", undetectable=("plasticity",)).judgement == "declared unseen"
    assert outcome(("plasticity",), verdict="no_gap", undetectable=()).judgement == "missed"


def test_the_summary_counts_and_the_table_has_a_row_each() -> None:
    outcomes = [outcome(("tangential_compliance",)), outcome(("free_play",)), outcome(())]
    assert outcome_table(outcomes).row_count == 3
    assert summary(outcomes)[0].startswith("1 false alarms in 1 records")
    assert summary(outcomes)[1].startswith("1 of 2 effects found")
