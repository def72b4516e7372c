"""The chapter on the rigid model of a compliant rig, on a record that the fast model made."""

from functools import cache

import pytest

from studies.steel_wires.diagnose import Chapter, chapter_of, findings
from tests.diagnosis_cases import diagnosed, record

pytestmark = pytest.mark.slow  # All read one chapter, which takes seconds.


@cache
def chapter(stiffness_N_per_mm: float = 167.0) -> Chapter:
    effect = {"tangential_compliance": {"stiffness_N_per_mm": stiffness_N_per_mm}}
    return chapter_of(diagnosed(record(effect, stiffness_N_per_mm="rigid")))


def test_the_spring_of_the_article_is_found_from_the_record_alone() -> None:
    assert [finding.statement for finding in findings(chapter()) if not finding.holds] == []


def test_the_loops_of_the_first_cycle_give_the_spring_within_its_interval() -> None:
    early = chapter().early_stiffness
    assert early.value == pytest.approx(167.0, rel=0.06)
    assert early.interval95[0] < 167.0 < early.interval95[1]


def test_the_calibrated_model_predicts_the_last_cycle() -> None:
    slip = chapter().differences(chapter().cycles[1])["slip_amplitude_um"]
    assert slip[0] > 5.0
    assert slip[1] < 0.7
