"""Observables of installed packages are measured, predicted, weighed and drawn: the worked example of the docs."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.frozen_states import frozen_states
from tests.independent_records import independent_record
from wirewear.diagnosis.diagnose import concluded
from wirewear.diagnosis.model.nominal import nominal_study
from wirewear.diagnosis.observe import registry
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.diagnosis.observe.registry import all_observables, row_labels
from wirewear.diagnosis.report.diagnosed import Diagnosed
from wirewear.diagnosis.report.page import page
from wirewear.diagnosis.report.pictures import drawn

TEXT = (Path(__file__).resolve().parent.parent / "docs" / "extending.md").read_text(encoding="utf-8")

#: The load rises by so much towards both ends of the stroke.
GUIDE = {"bent_guide": {"load_rise": 0.03}}


@pytest.fixture
def normal_bowl(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """The docs' observable, installed as they say; its name."""
    section = next(part for part in TEXT.split("\n## ") if part.startswith("An observable\n"))
    (code,) = re.findall(r"```python\n# (\S+)\n(.*?)```", section, re.DOTALL)
    (registration,) = re.findall(r"```toml\n(.*?)```", section, re.DOTALL)
    header, point = registration.strip().split("\n")
    module = tmp_path / code[0]
    module.parent.mkdir()
    module.write_text(code[1], encoding="utf-8")
    metadata = tmp_path / "plugin-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: plugin\nVersion: 1.0\n")
    group = re.fullmatch(r'\[project\.entry-points\."(.*)"\]', header)
    assert group is not None
    (metadata / "entry_points.txt").write_text(f"[{group[1]}]\n{point.replace(chr(34), '')}\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    registry._all_observables.cache_clear()
    yield point.split(" ")[0]
    monkeypatch.undo()
    registry._all_observables.cache_clear()


def diagnosed(effects: dict[str, dict[str, float]] | None = None) -> Diagnosed:
    record = independent_record(effects)
    return concluded(record, nominal_study(record), frozen_states(), reduce(record))


def test_without_it_a_bent_guide_is_not_seen() -> None:
    assert diagnosed(GUIDE).diagnosis.verdict == "no_gap"


def test_with_it_a_bent_guide_is_seen_where_it_is_and_in_the_report(normal_bowl: str) -> None:
    assert all_observables()[-1].name == normal_bowl
    answer = diagnosed(GUIDE)
    assert answer.diagnosis.verdict == "unexplained"
    assert answer.diagnosis.where[0].zone == normal_bowl
    words = "mostly in the normal force at the ends of the stroke over that in the middle"
    assert words in answer.diagnosis.sentence
    assert words in " ".join(TEXT.split())
    assert row_labels()[normal_bowl] == "normal force along the stroke"
    assert answer.diagnosis.where[0].observable in page(answer, drawn(answer))


@pytest.mark.slow
def test_with_it_other_answers_stay(normal_bowl: str) -> None:
    assert diagnosed().diagnosis.verdict == "no_gap"
    crosstalk = diagnosed({"force_crosstalk": {"coefficient": 0.05}})
    assert normal_bowl in {part.observable.name for part in crosstalk.observed.layout}
    assert crosstalk.diagnosis.verdict == "explained"
    assert crosstalk.diagnosis.causes[0].effect == "force_crosstalk"
