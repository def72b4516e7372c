"""Detected is not relevant: differences within a record's tolerance are stated with their size, and are no gap."""

from dataclasses import replace
from functools import cache

from tests.diagnosis_cases import diagnosed, record
from wirewear.diagnosis.diagnose import judged
from wirewear.records.tables import Tolerance
from wirewear.views.diagnosis_values import Diagnosis
from wirewear.views.diagnosis_wording import Diagnosed

#: A play that a record of little scatter shows, and that turns the loop 0.25 µm late on either flank, of 60 µm.
PLAY_um = 0.5


@cache
def found() -> Diagnosed:
    return diagnosed(record({"free_play": {"gap_um": PLAY_um}}, scatter=0.2))


def tolerant(displacement: float) -> Diagnosis:
    one = found()
    tables = one.record.tables.model_copy(update={"tolerance": Tolerance(displacement=displacement)})
    return judged(replace(one.record, tables=tables), one.study, one.states, one.observed, one.search).diagnosis


def test_a_difference_within_the_tolerance_is_no_gap_and_is_stated_with_its_size() -> None:
    answer = tolerant(0.01)
    assert answer.verdict == "no_gap"
    assert (answer.causes[0].effect, answer.causes[0].probability) == ("none", 1.0)
    relevance = answer.to_json()["relevance"]
    assert (relevance["detected"], relevance["relevant"]) == (True, False)
    # A flank is late by half of the play or, where the other one reaches into it, by more, up to the whole of it.
    assert 0.5 * PLAY_um <= 60.0 * relevance["largest"]["relative"] <= PLAY_um
    assert "free play" in answer.sentence
    assert "tolerance" in answer.sentence


def test_the_same_difference_beyond_a_finer_tolerance_has_its_cause() -> None:
    answer = tolerant(0.002)
    assert answer.verdict == "explained"
    assert answer.causes[0].effect == "free_play"
    assert answer.to_json()["relevance"]["relevant"] is True
