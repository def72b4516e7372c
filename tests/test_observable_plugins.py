"""Observables of installed packages are measured, predicted, weighed and drawn: the worked example of the docs."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.frozen_states import frozen_states
from tests.independent_records import independent_record
from tests.worked_examples import TEXT, install_example
from wirewear.diagnosis.diagnose import concluded
from wirewear.diagnosis.model.nominal import nominal_study
from wirewear.diagnosis.observe import registry
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.diagnosis.observe.registry import all_observables, row_labels
from wirewear.views.diagnosis_page import page
from wirewear.views.diagnosis_wording import Diagnosed

#: The load rises by so much towards both ends of the stroke; `test_diagnosis` has what is said without the example.
GUIDE = {"bent_guide": {"load_rise": 0.03}}


@pytest.fixture
def normal_bowl(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """The docs' observable, installed as they say; its name."""
    example = install_example("An observable", tmp_path, monkeypatch)
    registry._all_observables.cache_clear()
    yield example.name
    monkeypatch.undo()
    registry._all_observables.cache_clear()


def diagnosed(effects: dict[str, dict[str, float]] | None = None) -> Diagnosed:
    record = independent_record(effects)
    return concluded(record, nominal_study(record), frozen_states(), reduce(record))


@pytest.mark.slow
def test_with_it_a_bent_guide_is_seen_where_it_is_and_in_the_report(normal_bowl: str) -> None:
    assert all_observables()[-1].name == normal_bowl
    answer = diagnosed(GUIDE)
    assert answer.diagnosis.verdict == "unexplained"
    assert normal_bowl in {finding.zone for finding in answer.diagnosis.where}
    assert [one.seam for one in answer.diagnosis.resembles] == ["loading"]
    words = "behaves like a load that differs along the stroke"
    assert words in answer.diagnosis.sentence
    assert words in " ".join(TEXT.split())
    assert row_labels()[normal_bowl] == "normal force along the stroke"
    assert row_labels()[normal_bowl] in " ".join(TEXT.split())
    (found,) = (finding for finding in answer.diagnosis.where if finding.zone == normal_bowl)
    assert found.observable in page(answer)


@pytest.mark.slow
def test_with_it_other_answers_stay(normal_bowl: str) -> None:
    assert diagnosed().diagnosis.verdict == "no_gap"
    crosstalk = diagnosed({"force_crosstalk": {"coefficient": 0.05}})
    assert normal_bowl in {part.observable.name for part in crosstalk.observed.layout}
    assert crosstalk.diagnosis.verdict == "explained"
    assert crosstalk.diagnosis.causes[0].effect == "force_crosstalk"
